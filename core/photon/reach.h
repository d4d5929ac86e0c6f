#pragma once

#include <array>
#include <cmath>
#include <limits>

#include "core/math/float8.h"
#include "core/math/frame.h"
#include "core/photon/edges.h"

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
  bool whole() const { return !(nearest_sq_ < kInfinity); }
  /// Whether what lies so far off the center is within reach, by its projection on the tangent plane. Not to be asked
  /// where nothing is cut off.
  bool within(const Vec3& offset) const {
    const float x = glm::dot(offset, frame_.s);
    const float y = glm::dot(offset, frame_.t);
    const float turn = y / (std::abs(x) + std::abs(y) + kSmallest);
    const auto sector = static_cast<std::int32_t>((x >= 0 ? turn + 1 : 3 - turn) * kPerTurn) & (kSectors - 1);
    return x * x + y * y < reach_sq_[static_cast<std::uint32_t>(sector)];
  }
  /// The same of eight.
  [[gnu::always_inline]] Mask8 within(const Vec3x8& offset) const {
    const Float8 x = dot(frame_.s, offset);
    const Float8 y = dot(frame_.t, offset);
    const Float8 turn = y / (abs8(x) + abs8(y) + kSmallest);
    const Mask8 sectors = __builtin_convertvector((x >= 0 ? turn + 1 : 3 - turn) * kPerTurn, Mask8) & (kSectors - 1);
    return x * x + y * y < lookup8(reach_sq_.data(), sectors);
  }
  /// The share of an Epanechnikov kernel of squared radius `radius_sq` that lies within reach, in (0, 1].
  float coverage(float radius_sq) const { return radius_sq <= nearest_sq_ ? 1 : cut_coverage(radius_sq); }

 private:
  // Sectors are of equal diamond angle, y/(|x| + |y|) in the right half: no arc tangent.
  static constexpr float kPerTurn = kSectors / 4;
  static constexpr float kSmallest = std::numeric_limits<float>::min();

  float cut_coverage(float radius_sq) const;
  void cut(const Vec2& a, const Vec2& b, float radius_sq);

  Frame frame_;
  float nearest_sq_ = kInfinity;   // of reach_sq_, which is set where this is finite
  alignas(32) std::array<float, kSectors> reach_sq_;
};

}  // namespace photond
