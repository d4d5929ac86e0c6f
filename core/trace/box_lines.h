#pragma once

#include <cmath>

#include "core/math/types.h"

namespace photond {

/// The lines along a direction that meet a box: through one of the up to three faces by which they enter it.
class BoxLines {
 public:
  BoxLines() = default;
  /// Of an empty box there are none.
  explicit BoxLines(const Bounds3& bounds)
      : center_(bounds.empty() ? Vec3(0) : bounds.center()), half_(bounds.empty() ? Vec3(0) : 0.5f * bounds.extent()) {}

  const Vec3& center() const { return center_; }

  /// Area across a unit direction that the lines fill.
  float area(const Vec3& direction) const { return glm::dot(faces(), glm::abs(direction)); }
  /// The same, averaged over all directions: a quarter of the surface [Cauchy].
  float mean_area() const {
    const Vec3 faces = this->faces();
    return 0.5f * (faces.x + faces.y + faces.z);
  }
  /// Where a line enters, uniform over their area.
  Vec3 sample(const Vec3& direction, const Vec3& u) const {
    const Vec3 seen = faces() * glm::abs(direction);
    const float choice = u.z * (seen.x + seen.y + seen.z);
    const int axis = choice < seen.x ? 0 : choice < seen.x + seen.y ? 1 : 2;
    Vec3 at(0);
    at[axis] = std::copysign(1.0f, -direction[axis]);
    at[(axis + 1) % 3] = 2 * u.x - 1;
    at[(axis + 2) % 3] = 2 * u.y - 1;
    return center_ + at * half_;
  }
  /// Whether the line through a point does: no axis across it and an edge separates them.
  bool meets(const Vec3& point, const Vec3& direction) const {
    const Vec3 beside = glm::abs(glm::cross(point - center_, direction)), d = glm::abs(direction);
    return beside.x <= half_.y * d.z + half_.z * d.y && beside.y <= half_.z * d.x + half_.x * d.z &&
           beside.z <= half_.x * d.y + half_.y * d.x;
  }

 private:
  // Areas of the faces across each axis.
  Vec3 faces() const { return 4.0f * Vec3(half_.y * half_.z, half_.z * half_.x, half_.x * half_.y); }

  Vec3 center_{0};
  Vec3 half_{0};               // of its edges
};

}  // namespace photond
