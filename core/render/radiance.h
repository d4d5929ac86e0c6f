#pragma once

#include <cstdint>

#include "core/math/rng.h"
#include "core/photon/photon_maps.h"

namespace photond {

/// How indirect light is found at the lobes where photons can be gathered.
enum class Technique : std::uint8_t {
  trace,          ///< all lobes are followed: a path tracer
  density,        ///< photon density estimate in a fixed radius
  nearest,        ///< photon density estimate from the k nearest
  final_gather,   ///< caustics by `nearest`, the rest by rays whose ends are estimated by `nearest`
};

/// What the radiance along a ray depends on beside the scene.
struct RadianceSettings {
  Technique technique = Technique::trace;
  const PhotonMaps* maps = nullptr;      ///< null for Technique::trace
  float radius_sq = 0;                   ///< fixed (density) or largest (nearest, final_gather)
  std::uint32_t nearest = 64;            ///< k
  std::uint32_t max_depth = 65'536;      ///< vertices of a path
};

/// An estimate of the radiance (W·m⁻²·sr⁻¹) arriving along −ray.direction at ray.origin. Unbiased for
/// Technique::trace; otherwise with the bias of the density estimate, which vanishes with the radius (density).
Rgb estimate_incoming(const PreparedScene& scene, const RadianceSettings& settings, const Ray& ray, Rng& rng);

}  // namespace photond
