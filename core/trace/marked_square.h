#pragma once

#include <cstdint>
#include <vector>

#include "core/math/types.h"
#include "core/trace/surface_boxes.h"

namespace photond {

/// A piece of one side of an emissive triangle: within a ball.
struct EmitterPiece {
  Vec3 middle;
  float radius;
  Vec3 normal;                 ///< on that side
  float height;                ///< of the triangle along the normal, at least
  float extent;                ///< as EmitterTriangle's
};

/// Cells of a unit square, side by side.
class MarkedSquare {
 public:
  explicit MarkedSquare(std::uint32_t bits);

  std::uint32_t side() const { return side_; }
  bool marked(std::uint32_t x, std::uint32_t y) const { return marks_[y * side_ + x] != 0; }
  bool full() const { return left_ == 0; }

  /// Marks what `square_to_cosine_hemisphere` may map to directions along which the piece shines on something in the
  /// box.
  void mark(const EmitterPiece& piece, const SurfaceBox& box);

 private:
  void mark_rectangle(const Vec2& low, const Vec2& high);

  std::uint32_t side_;
  std::uint32_t left_;                   // cells that are not marked
  std::vector<std::uint8_t> marks_;
};

}  // namespace photond
