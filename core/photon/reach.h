#pragma once

#include <array>
#include <cmath>

#include "core/math/frame.h"
#include "core/trace/edges.h"

namespace photond {

/// How far a disc around a point extends on its surface before an edge cuts it off: a radius for each of kSectors
/// directions in the tangent plane. A kernel cut to this region and divided by what it keeps has no boundary bias
/// of order 0: no dark seams where walls meet, next to no light from beyond a thin wall.
class Reach {
 public:
  static constexpr int kSectors = 32;

  /// Without limit.
  Reach() = default;
  /// The reach within `radius` of `point`, in the plane through it with the unit normal `normal`.
  Reach(const Edges& edges, const Vec3& point, const Vec3& normal, float radius);

  /// Nothing is cut off: every photon counts and every coverage is 1.
  bool whole() const { return !cut_; }
  /// The squared reach in the direction of `offset` from the center, and the squared length of its projection on the
  /// tangent plane: what is shorter lies within reach. Not to be asked where nothing is cut off.
  float limit_sq(const Vec3& offset, float& across_sq) const {
    const float x = glm::dot(offset, frame_.s);
    const float y = glm::dot(offset, frame_.t);
    across_sq = x * x + y * y;
    return reach_sq_[sector(x, y)];
  }
  /// The share of an Epanechnikov kernel of squared radius `radius_sq` that lies within reach, in (0, 1].
  float coverage(float radius_sq) const { return cut_ ? cut_coverage(radius_sq) : 1; }

 private:
  // Sectors of equal diamond angle: no arc tangent.
  static int sector(float x, float y) {
    const float t = y / (std::abs(x) + std::abs(y) + std::numeric_limits<float>::min());
    const float turn = x >= 0 ? t + 1 : 3 - t;   // [0, 4)
    return static_cast<int>(turn * (kSectors / 4)) & (kSectors - 1);
  }
  float cut_coverage(float radius_sq) const;
  void cut(const Vec3& a, const Vec3& b, float radius_sq);

  Frame frame_;
  bool cut_ = false;
  std::array<float, kSectors> reach_sq_;
};

}  // namespace photond
