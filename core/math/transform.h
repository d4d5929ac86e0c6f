#pragma once

#include "core/math/types.h"

namespace photond {

/// Whether the transform turns left hands into right hands: then front faces are wound the other way.
inline bool is_mirrored(const Affine& m) { return glm::dot(m[0], glm::cross(m[1], m[2])) < 0; }

/// A normal under the transform, not normalized: the inverse transpose up to a positive scale, by cofactors, which
/// exist for singular matrices too.
inline Vec3 transform_normal(const Affine& m, const Vec3& n) {
  const Vec3 moved = n.x * glm::cross(m[1], m[2]) + n.y * glm::cross(m[2], m[0]) + n.z * glm::cross(m[0], m[1]);
  return is_mirrored(m) ? -moved : moved;
}

}  // namespace photond
