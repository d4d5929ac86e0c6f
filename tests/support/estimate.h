#pragma once

#include "core/photon/scales.h"

namespace photond::test {

/// Epanechnikov kernel on a disc: 2/π (1 − d²/r²)/r², in m⁻²; its integral over the disc is 1.
inline float epanechnikov(float distance_sq, float radius_sq) {
  return 2 * kInvPi * (1 - distance_sq / radius_sq) / radius_sq;
}

/// Radiance leaving `surface` towards the `wo` of `bsdf` by the photons within `radius_sq` > 0, through the lobes in
/// `mask`, as the widest of all radii gives it; to be divided by the number of emitted paths. No edge cuts the kernel.
inline Rgb estimate_radiance(const PhotonMap& map, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask,
                             float radius_sq) {
  ScaleEstimate sum;
  estimate_scales(map, surface, bsdf, mask, Reach(), radius_sq, Rgb(1), sum);
  return sum.widest;
}

}  // namespace photond::test
