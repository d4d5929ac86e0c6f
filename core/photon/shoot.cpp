// Jensen 1996: photon tracing. Veach 1997, §5.3: flux at shading normals.
#include "core/photon/shoot.h"

#include <array>
#include <bit>
#include <cmath>
#include <new>
#include <utility>

#include "core/math/rng.h"
#include "core/trace/coverage.h"
#include "core/trace/dispersion.h"
#include "core/trace/medium.h"
#include "core/trace/plain.h"
#include "core/trace/roulette.h"
#include "core/trace/scatter_flux.h"
#include "core/trace/specular.h"

namespace photond {

namespace {

float mean(const Rgb& c) { return (c.x + c.y + c.z) * (1.0f / 3); }

// By place and direction, so that photons are rounded apart. Exponents do not count: a scene in units of half a metre is
// the same scene.
[[gnu::always_inline]] inline PackedFlux rounded(const Rgb& flux, const Vec3& position, std::uint32_t from) {
  const auto bits = [](float v) { return std::bit_cast<std::uint32_t>(v) & 0x807fffffu; };
  return encode_flux(flux, from ^ 0x9e3779b1u * bits(position.x) ^ 0x85ebca77u * bits(position.y) ^
                               0xc2b2ae3du * bits(position.z));
}

// Walks that are advanced together: their plain bounces are computed several at a time, and while one waits for its
// triangle, the others' rays are traced.
constexpr std::uint32_t kBatch = kLanes;
// A scene of this size stays in the cache by itself.
constexpr std::uint64_t kCachedTriangles = 1024;

// One emitted path on its way through the scene.
struct Walk {
  Ray ray;
  Rgb flux{0};
  float power = 0;               // mean of flux
  float etendue = 0;             // EmissionSample::etendue as it is where the path is now
  std::uint32_t depth = 0;
  std::uint32_t map = 0;         // where it is stored: kGlobal, or kCaustic after only specular bounces
  Medium medium;
  Rng rng{0, RngPurpose::photon, 0, 0};
};
enum : std::uint32_t { kGlobal, kCaustic };

// Some of the walks of a batch, by index. Filled without branches: whether a walk belongs, none could predict.
struct Subset {
  std::array<std::uint32_t, kBatch> items;
  std::uint32_t size = 0;

  void add(std::uint32_t item, bool belongs = true) {
    items[size] = item;
    size += belongs;
  }
  const std::uint32_t* begin() const { return items.data(); }
  const std::uint32_t* end() const { return items.data() + size; }
};

// Advances a batch of walks together, one kind of work at a time.
class Shooter {
 public:
  Shooter(const PreparedScene& scene, const MapKey& key, std::uint64_t first, std::uint64_t last, PhotonBlock spent)
      : scene_(scene),
        key_(key.settings.seed, RngPurpose::photon, key.pass),
        next_(first),
        last_(last),
        per_unit_(1 / scene.lights.flux_unit()),
        most_normal_factor_(most_normal_factor(key.pass)),
        wavelengths_(wavelengths_of_pass(key.settings.seed, key.pass)),
        far_(scene.triangle_count > kCachedTriangles),
        only_caustic_(key.set == PhotonSet::caustic) {
    spent.global.clear();
    spent.caustic.clear();
    block_.global = std::move(spent.global);
    block_.caustic = std::move(spent.caustic);
    block_.global.reserve(2 * (last - first));
  }

  PhotonBlock run(std::vector<Ray>* record) {
    Subset all;
    for (std::uint32_t i = 0; i < kBatch; ++i) all.add(i);
    restart(all);
    while (live_.size > 0) {
      intersect(record);
      scatter_all();
      keep_photons();
    }
    return std::move(block_);
  }

 private:
  // Starts new paths in the place of those that have ended, while there are any.
  void restart(Subset ended) {
    while (ended.size > 0 && next_ < last_) ended = emit(ended);
  }

  // Lets a path leave a light for each of `places`. Returns those where nothing was emitted.
  Subset emit(const Subset& places) {
    std::array<std::uint32_t, kBatch> light;
    Subset starting, lanes, nothing;
    for (const std::uint32_t i : places) {
      if (next_ == last_) break;
      walks_[i].rng = Rng(key_, next_++);
      const float u = walks_[i].rng.next();
      light[i] = only_caustic_ ? scene_.lights.choose_casting(u) : scene_.lights.choose(u);
      scene_.lights.prefetch(light[i]);
      starting.add(i);
    }
    for (const std::uint32_t i : starting) {
      const bool in_lanes = scene_.lights.begin_emission(scene_.scene, light[i], walks_[i].rng, lanes.size, emissions_);
      lanes.add(i, in_lanes);
      if (!in_lanes) begin(i, light[i], scene_.lights.sample_emission(scene_.scene, light[i], walks_[i].rng), nothing);
    }
    emissions_.emit(lanes.size);
    for (std::uint32_t k = 0; k < lanes.size; ++k) {
      const std::uint32_t i = lanes.items[k];
      scene_.lights.share_emission(scene_.scene, light[i], k, emissions_);
      begin(i, light[i], emissions_.sample(k), nothing);
    }
    return nothing;
  }

  // Begins walk i with an emitted path; adds it to `nothing` where that carries nothing.
  void begin(std::uint32_t i, std::uint32_t light, const EmissionSample& emission, Subset& nothing) {
    Walk& walk = walks_[i];
    const Rgb flux = emission.flux * (only_caustic_ ? per_unit_ * scene_.lights.casting_weight(light) : per_unit_);
    const float power = mean(flux);
    walk.ray = emission.ray;
    walk.flux = flux;
    walk.power = power;
    walk.etendue = emission.etendue;
    walk.depth = 0;
    walk.map = kCaustic;
    walk.medium = scene_.light_media.at(scene_.scene, scene_.accel, light, emission.ray.origin);
    const bool finite = std::isfinite(power);
    const float unsent = finite ? power * scene_.lights.unsent(light) : 0;
    block_.ledger.emitted += power;
    block_.ledger.emitted += unsent;
    block_.ledger.escaped += unsent;
    if (!finite) block_.ledger.rejected += power;
    const bool started = finite && power > 0;
    live_.add(i, started);
    nothing.add(i, !started);
  }

  void intersect(std::vector<Ray>* record) {
    for (std::uint32_t k = 0; k < live_.size; ++k) {
      const Ray& ray = walks_[live_.items[k]].ray;
      if (record != nullptr) record->push_back(ray);
      block_.caustic_rays += walks_[live_.items[k]].map == kCaustic;
      rays_.set(k, ray);
    }
    scene_.accel.intersect(rays_, live_.size, Coherence::none, met_);
    for (std::uint32_t k = 0; k < live_.size; ++k) {
      Hit& hit = *new (&hits_[live_.items[k]]) Hit(met_[k]);  // in place: a copy would stall on its stores
      if (far_) scene_.placed_at(hit).prefetch_triangle(hit.triangle);
    }
    for (const std::uint32_t i : live_) {
      if (far_) scene_.placed_at(hits_[i]).prefetch_vertices(hits_[i].triangle);
    }
    block_.rays += live_.size;
  }

  void scatter_all() {
    Subset plain, specular, other, ended;
    for (const std::uint32_t i : live_) {
      const bool found = hits_[i].found();
      const PlacedMesh& mesh = scene_.placed_at(hits_[i]);
      const bool outside = !walks_[i].medium.active();
      const bool is_plain = mesh.plain & outside;
      const bool is_specular = kAllFeatures & ((mesh.shading == Shading::mirror) | (mesh.shading == Shading::glass)) & outside;
      plain.add(i, is_plain);
      specular.add(i, is_specular);
      other.add(i, found & !is_plain & !is_specular);
      ended.add(i, !found);
    }
    live_.size = 0;
    for (const std::uint32_t i : ended) block_.ledger.escaped += walks_[i].power;
    if (only_caustic_) {
      store_plain(plain, ended);
    } else {
      scatter_plain(plain, ended);
    }
    scatter_specular(specular, other, ended);
    scatter_other(other, ended);
    restart(ended);
  }

  // The walks at mirrors and smooth glass: as `scatter`, where nothing is stored. Adds to `other` those that are left.
  void scatter_specular(const Subset& specular, Subset& other, Subset& ended) {
    for (std::uint32_t k = 0; k < specular.size; ++k) {
      Walk& walk = walks_[specular.items[k]];
      const Hit& hit = hits_[specular.items[k]];
      specular_.set(k, scene_.placed[hit.instance], hit, walk.ray.direction, walk.flux, walk.depth, walk.rng);
    }
    specular_.scatter(specular.size);
    for (std::uint32_t k = 0; k < specular.size; ++k) {
      Walk& walk = walks_[specular.items[k]];
      if (specular_.settled[k] == 0) {
        other.add(specular.items[k]);
        continue;
      }
      walk.etendue /= specular_.squeeze[k];
      walk.ray.origin = specular_.origin[k];
      walk.ray.direction = specular_.next_direction[k];
      const bool alive = carry_finite(walk, specular_.next_flux[k]) && goes_on(walk);
      live_.add(specular.items[k], alive);
      ended.add(specular.items[k], !alive);
    }
  }

  void scatter_other(const Subset& other, Subset& ended) {
    for (std::uint32_t k = 0; k < other.size; ++k) {
      const Hit& hit = hits_[other.items[k]];
      surfaces_.set(k, scene_.placed[hit.instance], hit, walks_[other.items[k]].ray.direction);
    }
    surfaces_.compute(other.size);
    for (std::uint32_t k = 0; k < other.size; ++k) {
      const std::uint32_t i = other.items[k];
      const Hit& hit = hits_[i];
      const PlacedMesh& mesh = scene_.placed[hit.instance];
      const bool alive =
          scatter(walks_[i], hit, surfaces_.surface(k, scene_.scene, mesh, walks_[i].ray, hit));
      live_.add(i, alive);
      ended.add(i, !alive);
    }
  }

  // The walks at plain surfaces: as `scatter`, without what is not needed there and without a branch that depends
  // on chance.
  void scatter_plain(const Subset& plain, Subset& ended) {
    for (std::uint32_t k = 0; k < plain.size; ++k) {
      Walk& walk = walks_[plain.items[k]];
      const Hit& hit = hits_[plain.items[k]];
      bounces_.set(k, scene_.placed[hit.instance], hit, walk.ray.direction, walk.flux, walk.depth, walk.rng);
    }
    bounces_.scatter(plain.size);
    for (std::uint32_t k = 0; k < whole_vectors(plain.size); ++k) {
      const PackedFlux flux = rounded(bounces_.flux[k], bounces_.position[k], bounces_.from[k]);
      red_green_[k] = flux.red_green;
      blue_[k] = flux.blue;
    }
    for (std::uint32_t k = 0; k < plain.size; ++k) {
      Walk& walk = walks_[plain.items[k]];
      store(walk, bounces_.position[k], bounces_.from[k], bounces_.normal[k], {red_green_[k], blue_[k]}, walk.depth > 0);
      block_.ledger.absorbed += static_cast<double>(walk.power) - bounces_.next_power[k];
      walk.ray.origin = bounces_.origin[k];
      walk.ray.direction = bounces_.next_direction[k];
      walk.flux = bounces_.next_flux[k];
      walk.power = bounces_.next_power[k];
      walk.map = kGlobal;
      const bool alive = goes_on(walk);
      live_.add(plain.items[k], alive);
      ended.add(plain.items[k], !alive);
    }
  }

  // The same where all light that is scattered is left to paths from the eye.
  void store_plain(const Subset& plain, Subset& ended) {
    for (const std::uint32_t i : plain) {
      Walk& walk = walks_[i];
      if (walk.depth > 0) {
        const SurfacePoint s = make_surface(scene_.scene, walk.ray, hits_[i]);
        store(walk, s.position, encode_direction(-walk.ray.direction), encode_normal(s.ng), true);
      }
      carry(walk, Rgb(0));
      ended.add(i);
    }
  }

  // From the ray's end off the surface again; false where the path ends.
  bool scatter(Walk& walk, const Hit& hit, SurfacePoint surface) {
    if (walk.medium.active() || surface.material->transmission > 0) {
      carry(walk, walk.flux * walk.medium.transmittance(scene_.scene, surface, hit.t));
    }
    if (disperses(*surface.material)) disperse(surface, walk.flux, wavelengths_, walk.rng.next());
    surface.ior = walk.medium.relative_index(scene_.scene, surface);
    const Vec3 wi = -walk.ray.direction;
    const Bsdf bsdf(scene_.scene, surface, wi);
    const LobeMask gathered = gathered_lobes(bsdf);
    const std::uint32_t from = encode_direction(wi);
    store(walk, surface.position, from, encode_normal(surface.ng),
          rounded(as_stored(walk.flux, surface), surface.position, from),
          walk.depth > 0 && (gathered != kNoLobe || shared_on_gloss(walk, bsdf)));
    FluxSample sample;
    const bool scattered = scatter_flux(scene_.scene, surface, bsdf, wi, most_normal_factor_, walk.rng, sample);
    const float roulette = walk.rng.next();
    if (!scattered || (only_caustic_ && sample.by_gathered)) {
      carry(walk, Rgb(0));
      return false;
    }
    const Rgb next = walk.flux * sample.weight;
    // Survival in proportion to what is reflected: the power of a survivor changes only in colour.
    const float survival = survival_probability(max_component(next) / max_component(walk.flux), walk.depth);
    if (roulette >= survival) {
      carry(walk, Rgb(0));
      return false;
    }
    if (sample.by_gathered) walk.map = kGlobal;
    walk.medium.cross(scene_.scene, surface, sample.transmitted);
    if (sample.transmitted) walk.etendue /= compression(surface);
    walk.ray.origin = spawn_point(surface.position, surface.ng, surface.extent, sample.wi);
    walk.ray.direction = sample.wi;
    return carry_finite(walk, next * (1 / survival)) && goes_on(walk);
  }

  // A blended surface is met by a share of the photons, and by the same share of the paths that gather them: one of both
  // is enough.
  Rgb as_stored(const Rgb& flux, const SurfacePoint& s) const {
    if (!kAllFeatures || s.material->alpha_mode != AlphaMode::blend) return flux;
    return flux / coverage(scene_.scene, *s.mesh, s.triangle, s.u, s.v);
  }

  // Whether paths from the eye share this light where it falls on gloss.
  bool shared_on_gloss(const Walk& walk, const Bsdf& bsdf) const {
    return scene_.shares_gloss && walk.map == kCaustic && walk.etendue < kInfinity && gloss_lobes(bsdf) != kNoLobe;
  }

  // As `carry`; false where the flux is too large for a float.
  bool carry_finite(Walk& walk, const Rgb& flux) {
    if (is_finite(flux)) {
      carry(walk, flux);
      return true;
    }
    block_.ledger.rejected += walk.power;
    return false;
  }

  void carry(Walk& walk, const Rgb& flux) {
    const float power = mean(flux);
    block_.ledger.absorbed += static_cast<double>(walk.power) - power;
    walk.flux = flux;
    walk.power = power;
  }

  // After a bounce; false where the path ends.
  bool goes_on(Walk& walk) {
    if (++walk.depth < kMaxPhotonDepth) return walk.power > 0;
    block_.ledger.truncated += walk.power;
    return false;
  }

  void store(const Walk& walk, const Vec3& position, std::uint32_t from, std::uint32_t normal, bool wanted) {
    store(walk, position, from, normal, rounded(walk.flux, position, from), wanted);
  }

  void store(const Walk& walk, const Vec3& position, std::uint32_t from, std::uint32_t normal, const PackedFlux& flux,
             bool wanted) {
    std::uint32_t& count = stored_count_[walk.map];
    Photon& photon = stored_[walk.map][count];
    photon.position = position;
    photon.direction = from;
    photon.normal = normal;
    photon.flux = flux;
    photon.etendue = walk.etendue;
    count += wanted;
  }

  // Moves the batch's photons into the block.
  void keep_photons() {
    const Photon* global = stored_[kGlobal].data();
    const Photon* caustic = stored_[kCaustic].data();
    block_.global.insert(block_.global.end(), global, global + stored_count_[kGlobal]);
    block_.caustic.insert(block_.caustic.end(), caustic, caustic + stored_count_[kCaustic]);
    stored_count_ = {};
  }

  const PreparedScene& scene_;
  RngKey key_;
  std::uint64_t next_;           // the next path to emit
  std::uint64_t last_;
  float per_unit_;               // 1/Lights::flux_unit
  float most_normal_factor_;
  Vec3 wavelengths_;
  bool far_;
  bool only_caustic_;
  PhotonBlock block_;
  Subset live_;
  std::array<Walk, kBatch> walks_;
  std::array<Hit, kBatch> hits_;
  RayLanes rays_{};              // of the live walks, and what they meet
  HitLanes met_;
  EmissionLanes emissions_{};
  PlainBounces bounces_{};
  std::uint32_t red_green_[kLanes], blue_[kLanes];   // of their fluxes
  SpecularBounces specular_{};
  SurfaceLanes surfaces_{};
  std::array<std::array<Photon, kBatch + 1>, 2> stored_;  // one more: an unwanted photon is written, too
  std::array<std::uint32_t, 2> stored_count_{};
};

}  // namespace

PhotonBlock shoot(const PreparedScene& scene, const MapKey& key, std::uint64_t first, std::uint64_t last,
                  std::vector<Ray>* record, PhotonBlock spent) {
  if (scene.lights.empty()) return {};
  if (key.set == PhotonSet::caustic && scene.lights.casting_share() == 0) return {};
  return Shooter(scene, key, first, last, std::move(spent)).run(record);
}

}  // namespace photond
