#pragma once

#include <span>

#include "core/math/grid_distribution.h"
#include "core/math/types.h"

namespace photond {

/// From where on an emissive triangle light leaves: places are drawn about in proportion to how strongly they shine, by
/// texture and alpha. A place is the u in [0, 1]² of which `square_to_triangle` makes weights of vertices.
class EmissionPattern {
 public:
  struct Place {
    Vec2 u;
    float density;             ///< in terms of that of places which are drawn evenly
  };

  /// All places alike.
  EmissionPattern() = default;
  /// `radiance`: what leaves each of side² equal cells of the square, row by row, as GridDistribution's weights. All alike
  /// if that is nearly true.
  EmissionPattern(std::uint32_t side, std::span<const float> radiance);

  bool even() const { return side_ == 0; }
  /// A place for u in [0, 1)².
  Place draw(const Vec2& u) const;
  /// The density of a place; not 0.
  float density(const Vec2& u) const;

  std::uint64_t memory_bytes() const { return cells_.memory_bytes(); }

 private:
  float scale() const { return static_cast<float>(side_); }

  std::uint32_t side_ = 0;     // 0 where all are alike
  GridDistribution cells_;
};

}  // namespace photond
