#pragma once

#include <cstdint>

#include "core/photon/photon_map.h"
#include "core/trace/bsdf.h"

namespace photond {

/// Epanechnikov kernel on a disc: 2/π (1 − d²/r²)/r², in m⁻²; its integral over the disc is 1.
inline float epanechnikov(float distance_sq, float radius_sq) {
  return 2 * kInvPi * (1 - distance_sq / radius_sq) / radius_sq;
}

/// Radiance leaving `surface` towards the `wo` of `bsdf` by the photons within `radius_sq` > 0, through the lobes in
/// `mask`; to be divided by the number of emitted paths. Photons from behind the surface or of a very different
/// orientation do not count. Bias: O(r²), positive or negative, and dark by up to a half at the boundary of a surface.
Rgb estimate_radiance(const PhotonMap& map, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask,
                      float radius_sq);

/// The most photons nearest_radius_sq looks for.
inline constexpr std::uint32_t kMaxNearest = 4096;

/// The squared distance within which the k-nearest estimate is unbiased on uniform density: that of the k-th
/// photon, which itself has weight 0 under the Epanechnikov kernel [García et al. 2012]; `max_radius_sq` where
/// fewer photons are nearer than that. 1 ≤ k ≤ kMaxNearest.
float nearest_radius_sq(const PhotonMap& map, const Vec3& center, std::uint32_t k, float max_radius_sq);

}  // namespace photond
