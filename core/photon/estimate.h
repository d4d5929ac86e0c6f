#pragma once

#include <cstdint>

#include "core/photon/photon_map.h"
#include "core/trace/bsdf.h"

namespace photond {

/// Epanechnikov kernel on a disc: 2/π (1 − d²/r²)/r², in m⁻²; its integral over the disc is 1.
inline float epanechnikov(float distance_sq, float radius_sq) {
  return 2 * kInvPi * (1 - distance_sq / radius_sq) / radius_sq;
}

/// What the photons around a point say about the radiance that leaves it, and how far that may be off. With Φ_p and
/// ω_p a photon's flux and direction, γ_p = f(ω_p, ω_o) Φ_p, and K the Epanechnikov kernel of the radius r.
struct RadianceEstimate {
  Rgb radiance{0};            ///< L_r = Σ K γ
  Rgb bias_half{0};           ///< D = L_r − L_{r/√2}: E[2D] is the bias of L_r up to O(r⁴) [Hachisuka et al. 2010]
  Rgb variance{0};            ///< Σ (K γ)²: the variance of L_r over independent maps
  std::uint32_t count = 0;    ///< photons that were summed

  /// The estimate of two maps together, such as the global and the caustic one.
  RadianceEstimate& operator+=(const RadianceEstimate& other);
  /// In proportion, as the fluxes: the variance by the factor's square.
  RadianceEstimate& operator*=(const Rgb& factor);
};

/// Radiance leaving `surface` towards the `wo` of `bsdf` by the photons within `radius_sq` > 0, through the lobes in
/// `mask`; to be divided by the number of emitted paths (`operator*=`). Photons from behind the surface or of a very
/// different orientation do not count. Bias: O(r²), positive or negative.
RadianceEstimate estimate_radiance(const PhotonMap& map, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask,
                                   float radius_sq);

/// The most photons nearest_radius_sq looks for.
inline constexpr std::uint32_t kMaxNearest = 4096;

/// The squared distance within which the k-nearest estimate is unbiased on uniform density: that of the k-th
/// photon, which itself has weight 0 under the Epanechnikov kernel [García et al. 2012]; `max_radius_sq` where
/// fewer photons are nearer than that. 1 ≤ k ≤ kMaxNearest.
float nearest_radius_sq(const PhotonMap& map, const Vec3& center, std::uint32_t k, float max_radius_sq);

}  // namespace photond
