#pragma once

#include "core/render/camera_path.h"
#include "core/render/shadow_rays.h"

namespace photond {

/// Light that reaches the lobes of `surface` straight from the lights and leaves along the path: next-event estimation,
/// alone for lobes by which the path does not go on, weighted against going on for the others. Light to the followed
/// lobes belongs to it unless the path is gathering. It is added to `sample` by way of `shadows`.
void sample_direct_light(const PreparedScene& scene, const CameraPath& path, const SurfacePoint& surface,
                         const Bsdf& bsdf, const Lobes& lobes, CameraSampler& rng, std::uint32_t sample,
                         ShadowRays& shadows);

}  // namespace photond
