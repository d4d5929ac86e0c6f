#pragma once

#include <vector>

#include "core/scene/scene.h"

namespace photond {

/// Some of the surfaces: within a box, and within the convex hull of points.
struct SurfaceBox {
  Bounds3 bounds;
  std::vector<Vec3> corners;
};

/// All surfaces in boxes, about one for each cell of a coarse grid that some surface passes through.
std::vector<SurfaceBox> surface_boxes(const Scene& scene, const Bounds3& bounds);

}  // namespace photond
