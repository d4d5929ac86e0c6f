#pragma once

#include "core/trace/accel.h"
#include "core/trace/medium.h"

namespace photond {

/// Whether any surface is the border of a volume that is followed (Medium): only then need a path know where it starts.
bool has_followed_volumes(const Scene& scene);

/// The volumes around a point, by the faces that a ray from there meets. To be asked where any is followed.
Medium enclosing(const Scene& scene, const Accel& accel, const Vec3& point);

}  // namespace photond
