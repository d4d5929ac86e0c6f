#pragma once

#include "core/photon/photon_maps.h"
#include "core/render/settings.h"
#include "core/scene/camera.h"

namespace photond {

/// The first gather radius in metres for progressive passes: the median, over points that the camera sees, of the
/// radius that holds a few photons of one pass, kept within a few pixel footprints. Measured with a small photon map
/// of its own, never with photons of the passes. A pure function of its arguments; errors: cancelled.
Result<float> pilot_radius(const PreparedScene& scene, const Camera& camera, const PhotonSettings& photons,
                           const RenderSettings& settings, const Execution& execution);

}  // namespace photond
