#pragma once

#include <cmath>

#include "core/math/types.h"

namespace photond {

/// A right-handed orthonormal basis around a normal.
struct Frame {
  Vec3 s{1, 0, 0};
  Vec3 t{0, 1, 0};
  Vec3 n{0, 0, 1};

  Frame() = default;
  /// Any basis around the unit vector `normal`, continuous but at z = 0⁻ [Duff et al. 2017].
  explicit Frame(const Vec3& normal) : n(normal) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1 / (sign + n.z);
    const float b = n.x * n.y * a;
    s = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
    t = {b, sign + n.y * n.y * a, -n.y};
  }

  /// The basis around the unit vector `normal` whose `s` lies in the plane of it and `direction`, unless those are parallel.
  Frame(const Vec3& normal, const Vec3& direction) : Frame(normal) {
    const Vec3 slanted = direction - n * glm::dot(n, direction);
    const float length = glm::length(slanted);
    if (!(length > 0)) return;
    s = slanted / length;
    t = glm::cross(n, s);
  }

  Vec3 to_local(const Vec3& w) const { return {glm::dot(w, s), glm::dot(w, t), glm::dot(w, n)}; }
  Vec3 to_world(const Vec3& w) const { return w.x * s + w.y * t + w.z * n; }
};

}  // namespace photond
