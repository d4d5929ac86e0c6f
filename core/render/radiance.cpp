// Jensen 1996: photon map rendering. Veach 1997: multiple importance sampling.
#include "core/render/radiance.h"

#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/render/camera_path.h"
#include "core/render/direct_light.h"
#include "core/render/gather.h"
#include "core/render/plain_vertices.h"
#include "core/render/shadow_rays.h"
#include "core/trace/gathered.h"

namespace photond {

namespace {

// How quickly the footprint of a path grows, in metres a metre, after a bounce that scatters: caustics that are seen by
// way of one are blurred by it anyway.
constexpr float kScatteredSpread = 0.1f;

// Vertices from the camera on at which smooth glass is followed both ways: a bright reflection on water is seen in
// every pass instead of in one of fifty.
constexpr std::uint32_t kSplitDepth = 2;

// One path on its way through the scene.
struct Walk {
  CameraPath path;
  CameraSampler rng;
  std::uint32_t sample = 0;   // where its light belongs
};

// The walks from the camera of up to kLanes samples, advanced together, one bounce at a time.
class RadianceWalks {
 public:
  RadianceWalks(const PreparedScene& scene, const RadianceSettings& settings)
      : scene_(scene), settings_(settings), shadows_(scene.accel) {}

  void run(std::span<const Ray> rays, std::span<const CameraSampler> samplers, std::span<RadianceSample> samples) {
    samples_ = samples;
    shadows_.begin(samples);
    gathered_ = {};
    for (std::uint32_t i = 0; i < rays.size(); ++i) start(walks_[i], i, rays[i], samplers[i]);
    live_count_ = static_cast<std::uint32_t>(rays.size());
    std::iota(live_.begin(), live_.end(), 0);
    for (Coherence coherence = Coherence::high; live_count_ > 0; coherence = Coherence::none) {
      intersect(coherence);
      advance_all();
      shadows_.trace();
      begin_branches();
    }
    for (std::uint32_t i = 0; i < samples.size(); ++i) {
      samples[i].radiance += gathered_[i].widest;
      samples[i].bands = gathered_[i].bands;
    }
  }

 private:
  void start(Walk& walk, std::uint32_t sample, const Ray& ray, const CameraSampler& sampler) const {
    walk.path = {};
    walk.path.ray = ray;
    walk.path.footprint = settings_.pixel_width;
    walk.path.spread = settings_.pixel_spread;
    walk.rng = sampler;
    walk.sample = sample;
  }

  void intersect(Coherence coherence) {
    for (std::uint32_t k = 0; k < live_count_; ++k) rays_.set(k, walks_[live_[k]].path.ray);
    scene_.accel.intersect(rays_, live_count_, coherence, hits_);
  }

  void advance_all() {
    std::uint32_t plain = 0, other = 0;
    for (std::uint32_t k = 0; k < live_count_; ++k) {
      Walk& walk = walks_[live_[k]];
      const Hit hit = hits_[k];
      const PlacedMesh& mesh = scene_.placed_at(hit);
      if (is_plain(walk.path, mesh)) {
        plain_walks_[plain] = live_[k];
        if (mesh.emissive) add_emission(walk, make_surface(scene_.scene, walk.path.ray, hit), hit.t);
        plain_.set(plain++, mesh, hit, walk.path, walk.rng);
      } else if (hit.found()) {
        other_walks_[other] = {live_[k], k};
        surfaces_.set(other++, mesh, hit, walk.path.ray.direction);
      } else {
        add_environment(walk);
      }
    }
    live_count_ = 0;
    if (plain > 0) advance_plain(plain);
    if (other > 0) advance_other(other);
    for (std::uint32_t k = 0; k < live_count_; ++k) ++walks_[live_[k]].path.depth;
  }

  // Lets branches begin where there is room.
  void begin_branches() {
    if (branches_.empty() || live_count_ == kLanes) return;
    std::array<bool, kLanes> taken{};
    for (std::uint32_t k = 0; k < live_count_; ++k) taken[live_[k]] = true;
    for (std::uint32_t i = 0; i < kLanes && !branches_.empty(); ++i) {
      if (taken[i]) continue;
      walks_[i] = branches_.back();
      branches_.pop_back();
      live_[live_count_++] = i;
    }
  }

  // Whether a path may be advanced by PlainVertices.
  bool is_plain(const CameraPath& path, const PlacedMesh& mesh) const {
    return settings_.technique == Technique::trace && mesh.plain && !scene_.lights.empty() &&
           !path.medium.active() && path.depth < settings_.max_depth;
  }

  void advance_plain(std::uint32_t count) {
    plain_.shade(scene_, count);
    for (std::uint32_t i = 0; i < count; ++i) {
      Walk& walk = walks_[plain_walks_[i]];
      shadows_.add(walk.sample, plain_.shadow.ray(i), plain_.light[i]);
      walk.path.ray.origin = plain_.origin[i];
      walk.path.ray.direction = plain_.next_direction[i];
      walk.path.throughput = plain_.next_throughput[i];
      walk.path.last_pdf = plain_.next_pdf[i];
      live_[live_count_] = plain_walks_[i];
      live_count_ += !is_black(walk.path.throughput);
    }
  }

  void advance_other(std::uint32_t count) {
    surfaces_.compute(count);
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto [index, k] = other_walks_[i];
      Walk& walk = walks_[index];
      const Hit hit = hits_[k];
      const bool alive = scene_.placed_at(hit).in_place
                             ? advance(walk, hit, surfaces_.point(i, scene_.scene, hit))
                             : advance(walk, hit, make_surface(scene_.scene, walk.path.ray, hit));
      live_[live_count_] = index;
      live_count_ += alive;
    }
  }

  // From the ray's end off the surface again; false where the path ends.
  bool advance(Walk& walk, const Hit& hit, const SurfacePoint& surface) {
    CameraPath& path = walk.path;
    path.throughput *= path.medium.transmittance(surface, hit.t);
    add_emission(walk, surface, hit.t);
    // The last bounce's light may be found here as well as by sampling it from there: only now the path is cut.
    if (path.depth == settings_.max_depth) {
      samples_[walk.sample].truncated = true;
      return false;
    }
    const Bsdf bsdf(scene_.scene, surface, -path.ray.direction);
    const Lobes lobes = divide(bsdf, technique(path));
    sample_direct_light(scene_, path, surface, bsdf, lobes, walk.rng, walk.sample, shadows_);
    path.footprint += path.spread * hit.t;
    Merge merge;
    if (lobes.gathered != kNoLobe) merge = add_indirect(walk, surface, bsdf, lobes);
    return follow(walk, surface, bsdf, lobes, merge);
  }

  Technique technique(const CameraPath& path) const { return path.gathering ? Technique::nearest : settings_.technique; }

  void add(const Walk& walk, const Rgb& light) { samples_[walk.sample].radiance += walk.path.throughput * light; }

  // MIS weight of light found by following a lobe, against sampling it from the previous vertex.
  static float hit_weight(const CameraPath& path, float pdf_direct) {
    return path.last_pdf == 0 ? 1 : power_heuristic(path.last_pdf, pdf_direct);
  }

  void add_environment(const Walk& walk) {
    const CameraPath& path = walk.path;
    if (path.gathering || !scene_.scene.environment.active()) return;
    const Vec3& direction = path.ray.direction;
    const float pdf_direct = path.depth > 0 ? scene_.lights.pdf_environment(scene_.scene, direction) : 0;
    const float etendue =
        path.chained ? scene_.lights.environment_etendue(pdf_direct, path.ray.origin, direction) : kInfinity;
    add(walk, scene_.scene.environment.from(direction) * (hit_weight(path, pdf_direct) * path.share(etendue)));
  }

  void add_emission(const Walk& walk, const SurfacePoint& surface, float distance) {
    const CameraPath& path = walk.path;
    if (path.gathering || !surface.material->emissive()) return;
    const Rgb emitted = emitted_radiance(scene_.scene, surface);
    if (is_black(emitted)) return;
    const Vec3& direction = path.ray.direction;
    const float pdf_direct = path.last_pdf > 0 ? scene_.lights.pdf_direct(surface, direction, distance) : 0;
    const float etendue = path.chained ? scene_.lights.etendue(surface, -direction) : kInfinity;
    add(walk, emitted * (hit_weight(path, pdf_direct) * path.share(etendue)));
  }

  // Light that photons bring to the gathered lobes, and how it is shared with a path that goes on.
  Merge add_indirect(Walk& walk, const SurfacePoint& surface, const Bsdf& bsdf, const Lobes& lobes) {
    ScaleEstimate& gathered = gathered_[walk.sample];
    switch (technique(walk.path)) {
      case Technique::trace:
        break;
      case Technique::merge:
        return gather_caustic(settings_, scene_.lights, walk.path, surface, bsdf, lobes, gathered);
      case Technique::density:
        gather_density(settings_, walk.path, surface, bsdf, lobes, gathered);
        break;
      case Technique::nearest:
        add(walk, gather_all(settings_, surface, bsdf, lobes));
        break;
      case Technique::final_gather:
        add(walk, gather_nearest(settings_, *settings_.caustic, surface, bsdf, lobes.gathered));
        gather(walk, surface, bsdf, lobes.gathered);
        break;
    }
    return {};
  }

  // Sends a final-gather ray on its own way.
  void gather(Walk& walk, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask) {
    const auto sample = bsdf.sample(Vec3(walk.rng.next4()), mask, Transport::radiance);
    if (!sample) return;
    Walk& branch = branch_off(walk);
    continue_by(branch.path, surface, *sample, 1);
    branch.path.gathering = true;
  }

  bool follow(Walk& walk, const SurfacePoint& surface, const Bsdf& bsdf, const Lobes& lobes, const Merge& merge) {
    CameraPath& path = walk.path;
    if (lobes.followed == kNoLobe && lobes.gathered_share == 0) return false;
    if (path.depth < kSplitDepth && settings_.technique != Technique::trace) {
      const float reflected = bsdf.smooth_glass_reflectance();
      if (reflected > 0 && reflected < 1) return follow_both(walk, surface, bsdf, reflected);
    }
    Vec4 u = walk.rng.next4();
    const bool scatters = u.z < lobes.gathered_share;
    const float chosen = scatters ? lobes.gathered_share : lobes.followed_share;
    u.z = std::min((scatters ? u.z : u.z - lobes.gathered_share) / chosen, 0x1.fffffep-1f);
    const LobeMask mask = scatters ? lobes.gathered : lobes.followed;
    const auto sample = bsdf.sample(Vec3(u), mask, Transport::radiance);
    if (!sample) return false;
    continue_by(path, surface, *sample, 1 / chosen);
    path.last_pdf *= chosen;
    if (scatters) {
      path.scattered = true;
      path.chained = false;
      path.ratio = merge.ratio(surface, bsdf, mask, sample->wi, 1);
      path.spread = std::max(path.spread, kScatteredSpread);
    }
    const float survival = roulette_survival(path.throughput, path.compression, path.depth);
    path.throughput /= survival;
    return u.w < survival;
  }

  // Goes on by refraction and lets the reflection branch off, each with its share instead of by chance.
  bool follow_both(Walk& walk, const SurfacePoint& surface, const Bsdf& bsdf, float reflected) {
    const auto reflection = bsdf.sample({0, 0, 0}, kGlassLobe, Transport::radiance);
    const auto refraction = bsdf.sample({0, 0, 0x1.fffffep-1f}, kGlassLobe, Transport::radiance);
    if (reflection) continue_by(branch_off(walk).path, surface, *reflection, reflected);
    if (refraction) continue_by(walk.path, surface, *refraction, 1 - reflected);
    return refraction.has_value();
  }

  // A copy of the walk that goes on by itself, from the next bounce on.
  Walk& branch_off(Walk& walk) {
    Walk& branch = branches_.emplace_back(walk);
    branch.rng = walk.rng.branch();
    ++branch.path.depth;
    return branch;
  }

  static void continue_by(CameraPath& path, const SurfacePoint& surface, const BsdfSample& sample, float share) {
    path.throughput *= sample.weight * share;
    if (sample.transmitted) {
      path.compression *= compression(*surface.material, surface.front);
      path.ratio *= compression(*surface.material, surface.front);
    }
    path.chained = path.scattered;
    path.medium.cross(surface, sample);
    path.last_pdf = sample.pdf_w;
    path.ray = spawn_ray(surface, sample.wi);
  }

  const PreparedScene& scene_;
  const RadianceSettings& settings_;
  std::span<RadianceSample> samples_;
  std::array<Walk, kLanes> walks_;
  std::array<std::uint32_t, kLanes + 1> live_;   // those of the walks that go on; one more is written, too
  std::uint32_t live_count_ = 0;
  std::vector<Walk> branches_;                   // those that wait for a place among the walks
  RayLanes rays_{};                              // of the live walks
  HitLanes hits_;
  PlainVertices plain_{};
  std::array<std::uint32_t, kLanes> plain_walks_;
  struct Other {
    std::uint32_t walk, lane;   // lane: of its hit
  };
  std::array<Other, kLanes> other_walks_;
  SurfaceLanes surfaces_{};                      // of those
  ShadowRays shadows_;
  std::array<ScaleEstimate, kLanes> gathered_;
};

}  // namespace

Lobes divide(const Bsdf& bsdf, Technique technique) {
  if (technique == Technique::trace) return {kNoLobe, bsdf.lobes(), 0, 1};
  const LobeMask gathered = gathered_lobes(bsdf);
  const LobeMask followed = bsdf.lobes() & ~gathered;
  if (technique != Technique::merge) return {gathered, followed, 0, 1};
  if (gathered == kNoLobe || followed == kNoLobe) return {gathered, followed, gathered != kNoLobe ? 1.0f : 0.0f, 1};
  const float share = bsdf.share(gathered);
  return {gathered, followed, share, 1 - share};
}

void estimate_incoming(const PreparedScene& scene, const RadianceSettings& settings, std::span<const Ray> rays,
                       std::span<const CameraSampler> samplers, std::span<RadianceSample> samples) {
  RadianceWalks walks(scene, settings);
  for (std::size_t first = 0; first < rays.size(); first += kLanes) {
    const std::size_t count = std::min<std::size_t>(kLanes, rays.size() - first);
    walks.run(rays.subspan(first, count), samplers.subspan(first, count), samples.subspan(first, count));
  }
}

}  // namespace photond
