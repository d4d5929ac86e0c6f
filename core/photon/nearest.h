#pragma once

#include <cstdint>

#include "core/photon/photon_map.h"

namespace photond {

/// The most photons nearest_radius_sq looks for.
inline constexpr std::uint32_t kMaxNearest = 4096;

/// The squared distance within which the k-nearest estimate is unbiased on uniform density: that of the k-th
/// photon, which itself has weight 0 under the Epanechnikov kernel [García et al. 2012]; `max_radius_sq` where
/// fewer photons are nearer than that. 1 ≤ k ≤ kMaxNearest.
float nearest_radius_sq(const PhotonMap& map, const Vec3& center, std::uint32_t k, float max_radius_sq);

}  // namespace photond
