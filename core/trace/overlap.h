#pragma once

#include "core/scene/scene.h"

namespace photond {

/// Half the surface of a box, 0 of an empty one: lines meet a convex body in proportion to its surface.
float half_surface(const Bounds3& box);

/// How much instances are in one another's way: the mean number of pairs whose bounding boxes overlap where a random
/// line through the scene passes. 0 for objects that lie apart, and for those of a few triangles; infinite where there
/// are too many instances to look at each pair.
float overlap(const Scene& scene);

}  // namespace photond
