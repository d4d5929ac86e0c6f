#pragma once

#include "core/math/warp.h"
#include "core/photon/scales.h"
#include "core/render/radiance.h"
#include "core/trace/medium.h"
#include "core/trace/roulette.h"

namespace photond {

/// Where a path from the camera stands, and what it carries.
struct CameraPath {
  Ray ray;
  Rgb throughput{1};
  float compression = 1;         ///< of radiance by the refractions so far
  float footprint = 0;           ///< metres across, at the ray's origin
  float spread = 0;              ///< what it grows by in a metre
  Medium medium;
  std::uint32_t depth = 0;
  float last_pdf = 0;            ///< per solid angle, of the ray's direction; 0 of a mirror's, and of the camera's
  bool gathering = false;        ///< a final-gather ray: leaves emission to where it comes from, and ends in photons

  // Where light is shared with photons.
  bool scattered = false;   ///< a gathered lobe was followed
  bool shared = false;      ///< or gloss: photons bring there what follows by followed lobes
  bool chained = false;     ///< and since then at least one of those
  float ratio = 0;          ///< Merge::ratio there for an étendue of 1, as it is where the path is now

  /// Share of the path in light from a source of this étendue that it meets, against photons that arrive where it
  /// is shared.
  float share(float etendue) const { return chained ? share_of(ratio * etendue) : 1; }
  /// The same for light that is sampled through the followed lobes of `surface`, from `wi`.
  float share(const SurfacePoint& surface, const Vec3& wi, float etendue) const {
    if (!shared) return 1;
    const bool transmitted = glm::dot(wi, surface.ng) < 0;
    return share_of(ratio * (transmitted ? photond::compression(surface) : 1) * etendue);
  }

 private:
  // All where no photon can arrive: an infinite or undefined ratio.
  static float share_of(float rho) { return rho < kInfinity ? rho / (1 + rho) : 1; }
};

/// Probability with which Russian roulette lets a path go on from its vertex at `depth` with a throughput: by the weight
/// without refraction's compression, which a later refraction undoes. Not on the first few bounces, which carry most of
/// the picture.
inline float roulette_survival(const Rgb& throughput, float compression, std::uint32_t depth) {
  static constexpr std::uint32_t kFirst = 4;
  return choose(depth < kFirst, 1, survival_probability(max_component(throughput) * compression, depth));
}

/// The lobes of a surface, by what a technique does with them.
struct Lobes {
  LobeMask gathered = kNoLobe;   ///< where photons are gathered
  LobeMask followed = kNoLobe;   ///< the others
  float gathered_share = 0;      ///< probability with which a path goes on by a gathered lobe; 0: it ends there
  float followed_share = 1;
};

Lobes divide(const Bsdf& bsdf, Technique technique);

/// MIS weight of the technique of density `pdf` against one of density `other` [Veach 1997, §9.2].
inline float power_heuristic(float pdf, float other) {
  const float ratio = other / pdf;   // densities of tiny distant lights have no finite square
  return choose(pdf > 0, 1 / (1 + ratio * ratio), 0);
}

}  // namespace photond
