#pragma once

#include "core/render/radiance.h"
#include "core/scene/camera.h"

namespace photond {

/// How much noise a method leaves in a pass as a pilot tells it: variance over squared radiance, on average over the
/// picture.
struct PilotNoise {
  double photons = 0;   ///< where indirect light is estimated from photon densities
  double paths = 0;     ///< where paths go on
};

/// Paths through each pixel of the pilot's grid: few, which miss rare bright ones, and so many that they seldom do.
inline constexpr std::uint32_t kFewPilotPaths = 8;
inline constexpr std::uint32_t kManyPilotPaths = 32;

/// Sends `count` ≤ kManyPilotPaths paths through the middle of each of a grid of pixels. `paths` are the settings of a
/// method that goes on (Technique::trace or merge), `guide` tells how dense photons lie. A pure function of its
/// arguments; undefined once `execution` is cancelled.
PilotNoise measure_noise(const PreparedScene& scene, const Camera& camera, float aspect, const RadianceSettings& paths,
                         const GatherGuide& guide, std::uint32_t count, const Execution& execution);

}  // namespace photond
