// Jensen 1996: photon tracing. Veach 1997, §5.3: flux at shading normals.
#include "core/photon/shoot.h"

#include <array>
#include <cmath>
#include <new>

#include "core/math/rng.h"
#include "core/trace/medium.h"
#include "core/trace/roulette.h"

namespace photond {

namespace {

double mean(const Rgb& c) { return (static_cast<double>(c.x) + c.y + c.z) * (1.0 / 3); }

// |wi·ns||wo·ng| / (|wi·ng||wo·ns|) for the photon's incoming direction `in` and outgoing direction `out`: what
// makes the photon's walk the adjoint of the camera's on interpolated normals. Bounded: at grazing incidence it
// explodes.
float shading_normal_factor(const SurfacePoint& s, const Vec3& in, const Vec3& out) {
  static constexpr float kMax = 8;
  const float above = std::abs(glm::dot(in, s.ns) * glm::dot(out, s.ng));
  const float below = std::abs(glm::dot(in, s.ng) * glm::dot(out, s.ns));
  return below > 0 ? std::min(above / below, kMax) : 0;
}

// One emitted path on its way through the scene.
class PhotonWalk {
 public:
  PhotonWalk(const PreparedScene& scene, PhotonBlock& block) : scene_(&scene), block_(&block) {}

  // Leaves a light; false where that emits nothing.
  bool start(const Rng& rng) {
    rng_ = rng;
    const EmissionSample emission = scene_->lights.sample_emission(scene_->scene, rng_);
    ray_ = emission.ray;
    flux_ = emission.flux;
    medium_ = {};
    depth_ = 0;
    specular_chain_ = true;
    power_ = mean(flux_);
    block_->ledger.emitted += power_;
    return power_ > 0;
  }

  const Ray& ray() const { return ray_; }

  // From the ray's end off the surface again; false where the path ends.
  bool advance(const Hit& hit) {
    if (!hit.found()) {
      block_->ledger.escaped += power_;
      return false;
    }
    const SurfacePoint surface = make_surface(scene_->scene, ray_, hit);
    if (medium_.active() || surface.material->transmission > 0) absorb(flux_ * medium_.transmittance(surface, hit.t));
    const Vec3 wi = -ray_.direction;
    const Bsdf bsdf(scene_->scene, surface, wi);
    const LobeMask gathered = gathered_lobes(bsdf);
    if (depth_ > 0 && gathered != kNoLobe) store(surface, wi);
    if (!scatter(surface, bsdf, gathered, wi)) return false;
    if (++depth_ < kMaxPhotonDepth) return true;
    block_->ledger.truncated += power_;
    return false;
  }

 private:
  void store(const SurfacePoint& surface, const Vec3& wi) {
    auto& photons = specular_chain_ ? block_->caustic : block_->global;
    photons.emplace_back(surface.position, encode_direction(wi), encode_normal(surface.ng), flux_);
  }

  bool scatter(const SurfacePoint& surface, const Bsdf& bsdf, LobeMask gathered, const Vec3& wi) {
    const Vec2 u = rng_.next2();
    const float choice = rng_.next();
    const auto sample = bsdf.sample({u, choice}, kAllLobes, Transport::flux);
    const float roulette = rng_.next();
    if (!sample) {
      absorb(Rgb(0));
      return false;
    }
    Rgb next = flux_ * sample->weight;
    if (surface.smooth) next *= shading_normal_factor(surface, wi, sample->wi);
    if (!is_finite(next)) {
      block_->ledger.rejected += power_;
      return false;
    }
    // Survival in proportion to what is reflected: the power of a survivor changes only in colour.
    const float survival = survival_probability(max_component(next) / max_component(flux_), depth_);
    if (roulette >= survival) {
      absorb(Rgb(0));
      return false;
    }
    absorb(next * (1 / survival));
    if ((sample->lobe & gathered) != 0) specular_chain_ = false;
    medium_.cross(surface, *sample);
    ray_.origin = spawn_point(surface.position, surface.ng, surface.extent, sample->wi);
    ray_.direction = sample->wi;
    return true;
  }

  void absorb(const Rgb& remaining) {
    const double power = mean(remaining);
    block_->ledger.absorbed += power_ - power;
    flux_ = remaining;
    power_ = power;
  }

  const PreparedScene* scene_;
  PhotonBlock* block_;
  Rng rng_{0, RngPurpose::photon, 0, 0};
  Ray ray_;
  Rgb flux_{0};
  double power_ = 0;             // mean of flux_
  Medium medium_;
  std::uint32_t depth_ = 0;
  bool specular_chain_ = true;   // only specular bounces so far
};

// Walks that are advanced in turn: while one waits for its triangle, the others' rays are traced.
constexpr std::size_t kBatch = 16;
// A scene of this size stays in the cache by itself.
constexpr std::uint64_t kCachedTriangles = 1024;

}  // namespace

PhotonBlock shoot(const PreparedScene& scene, const MapKey& key, std::uint64_t first, std::uint64_t last,
                  std::vector<Ray>* record) {
  PhotonBlock block;
  if (scene.lights.empty()) return block;
  block.global.reserve(2 * (last - first));
  std::vector<PhotonWalk> walks(kBatch, PhotonWalk(scene, block));
  std::array<Hit, kBatch> hits;
  std::uint64_t next = first;
  // Starts the next path that carries anything; false when all have been.
  const auto restart = [&](PhotonWalk& walk) {
    while (next < last) {
      if (walk.start(Rng(key.settings.seed, RngPurpose::photon, key.pass, next++))) return true;
    }
    return false;
  };
  const bool far = scene.triangle_count > kCachedTriangles;
  std::size_t active = 0;
  while (active < kBatch && restart(walks[active])) ++active;
  while (active > 0) {
    for (std::size_t i = 0; i < active; ++i) {
      if (record != nullptr) record->push_back(walks[i].ray());
      new (&hits[i]) Hit(scene.accel.intersect(walks[i].ray()));  // in place: a copy would stall on its stores
      if (far) prefetch_triangle(scene.scene, hits[i]);
    }
    block.rays += active;
    for (std::size_t i = 0; far && i < active; ++i) prefetch_vertices(scene.scene, hits[i]);
    for (std::size_t i = 0; i < active;) {
      if (walks[i].advance(hits[i]) || restart(walks[i])) {
        ++i;
      } else {
        --active;
        walks[i] = walks[active];
        hits[i] = hits[active];
      }
    }
  }
  return block;
}

}  // namespace photond
