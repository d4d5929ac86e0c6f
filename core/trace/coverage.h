#pragma once

#include "core/scene/scene.h"

namespace photond {

/// Share of the light on a place of a surface that meets it, in [0, 1], by the alpha of its material: 1 where that is
/// opaque, 0 or 1 of a mask. `u`, `v`: barycentric, as in Hit.
float coverage(const Scene& scene, const Mesh& mesh, std::uint32_t triangle, float u, float v);

}  // namespace photond
