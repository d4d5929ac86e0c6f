#pragma once

#include "core/render/camera_path.h"

namespace photond {

/// Light that reaches the lobes of `surface` straight from the lights and leaves along the path, without its
/// throughput: next-event estimation, alone for lobes by which the path does not go on, weighted against going on for
/// the others. `see_followed`: light to the followed lobes belongs to it.
Rgb sample_direct_light(const PreparedScene& scene, const CameraPath& path, const SurfacePoint& surface,
                        const Bsdf& bsdf, const Lobes& lobes, bool see_followed, CameraSampler& rng);

}  // namespace photond
