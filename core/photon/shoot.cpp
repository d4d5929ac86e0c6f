// Jensen 1996: photon tracing. Veach 1997, §5.3: flux at shading normals.
#include "core/photon/shoot.h"

#include <cmath>

#include "core/math/rng.h"
#include "core/trace/medium.h"
#include "core/trace/roulette.h"

namespace photond {

namespace {

double mean(const Rgb& c) { return (static_cast<double>(c.x) + c.y + c.z) / 3; }

// |wi·ns||wo·ng| / (|wi·ng||wo·ns|) for the photon's incoming direction `in` and outgoing direction `out`: what
// makes the photon's walk the adjoint of the camera's on interpolated normals. Bounded: at grazing incidence it
// explodes.
float shading_normal_factor(const SurfacePoint& s, const Vec3& in, const Vec3& out) {
  static constexpr float kMax = 8;
  const float above = std::abs(glm::dot(in, s.ns) * glm::dot(out, s.ng));
  const float below = std::abs(glm::dot(in, s.ng) * glm::dot(out, s.ns));
  return below > 0 ? std::min(above / below, kMax) : 0;
}

// One emitted path, walked to its end.
class PhotonWalk {
 public:
  PhotonWalk(const PreparedScene& scene, Rng rng, PhotonBlock& block, std::vector<Ray>* record)
      : scene_(scene), rng_(rng), block_(block), record_(record) {}

  void run() {
    const EmissionSample emission = scene_.lights.sample_emission(scene_.scene, rng_);
    ray_ = emission.ray;
    flux_ = emission.flux;
    block_.ledger.emitted += mean(flux_);
    for (depth_ = 0; !is_black(flux_); ++depth_) {
      if (depth_ == kMaxPhotonDepth) {
        block_.ledger.truncated += mean(flux_);
        return;
      }
      if (!step()) return;
    }
  }

 private:
  // To the next surface and off it again; false where the path ends.
  bool step() {
    if (record_ != nullptr) record_->push_back(ray_);
    ++block_.rays;
    const Hit hit = scene_.accel.intersect(ray_);
    if (!hit.found()) {
      block_.ledger.escaped += mean(flux_);
      return false;
    }
    const SurfacePoint surface = make_surface(scene_.scene, ray_, hit);
    absorb(flux_ * medium_.transmittance(surface, hit.t));
    const Vec3 wi = -ray_.direction;
    const Bsdf bsdf(scene_.scene, surface, wi);
    if (depth_ > 0 && gathered_lobes(bsdf) != kNoLobe) store(surface, wi);
    return scatter(surface, bsdf, wi);
  }

  void store(const SurfacePoint& surface, const Vec3& wi) {
    auto& photons = specular_chain_ ? block_.caustic : block_.global;
    photons.push_back({surface.position, encode_direction(wi), encode_direction(surface.ng), flux_});
  }

  bool scatter(const SurfacePoint& surface, const Bsdf& bsdf, const Vec3& wi) {
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
      block_.ledger.rejected += mean(flux_);
      return false;
    }
    // Survival in proportion to what is reflected: the power of a survivor changes only in colour.
    const float survival = survival_probability(max_component(next) / max_component(flux_), depth_);
    if (roulette >= survival) {
      absorb(Rgb(0));
      return false;
    }
    absorb(next / survival);
    if ((sample->lobe & gathered_lobes(bsdf)) != 0) specular_chain_ = false;
    medium_.cross(surface, *sample);
    ray_ = spawn_ray(surface, sample->wi);
    return true;
  }

  void absorb(const Rgb& remaining) {
    block_.ledger.absorbed += mean(flux_) - mean(remaining);
    flux_ = remaining;
  }

  const PreparedScene& scene_;
  Rng rng_;
  PhotonBlock& block_;
  std::vector<Ray>* record_;
  Ray ray_;
  Rgb flux_{0};
  Medium medium_;
  std::uint32_t depth_ = 0;
  bool specular_chain_ = true;   // only specular bounces so far
};

}  // namespace

PhotonBlock shoot(const PreparedScene& scene, const MapKey& key, std::uint64_t first, std::uint64_t last,
                  std::vector<Ray>* record) {
  PhotonBlock block;
  if (scene.lights.empty()) return block;
  for (std::uint64_t path = first; path < last; ++path) {
    const Rng rng(key.settings.seed, RngPurpose::photon, key.pass, path);
    PhotonWalk(scene, rng, block, record).run();
  }
  return block;
}

}  // namespace photond
