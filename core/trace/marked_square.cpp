#include "core/trace/marked_square.h"

#include <algorithm>
#include <cmath>

#include "core/math/frame.h"
#include "core/math/warp.h"

namespace photond {

namespace {

// How far apart two points of the square are at most for each unit between their images on the disk: the reciprocal of
// the smallest singular value of square_to_disk, rounded up.
constexpr float kSquareOfDisk = 0.885f;

// What rounding of directions may do.
constexpr float kRounding = 1e-5f;

// How far along a direction the surfaces may reach.
float highest(const SurfaceBox& box, const Vec3& direction) {
  float high = -kInfinity;
  for (const Vec3& corner : box.corners) high = std::max(high, glm::dot(corner, direction));
  return high;
}

}  // namespace

MarkedSquare::MarkedSquare(std::uint32_t bits) : side_(1u << bits), left_(side_ * side_), marks_(left_, 0) {}

void MarkedSquare::mark_rectangle(const Vec2& low, const Vec2& high) {
  const float cells = static_cast<float>(side_);
  const auto first = [&](float x) { return static_cast<std::uint32_t>(std::clamp(x * cells, 0.0f, cells - 1)); };
  for (std::uint32_t y = first(low.y); y <= first(high.y); ++y) {
    for (std::uint32_t x = first(low.x); x <= first(high.x); ++x) {
      std::uint8_t& mark = marks_[y * side_ + x];
      left_ -= mark == 0;
      mark = 1;
    }
  }
}

// Seen from anywhere on the piece, the box lies within a cone. On the disk that the hemisphere is projected to, two
// directions are no farther apart than on the sphere.
void MarkedSquare::mark(const EmitterPiece& piece, const SurfaceBox& box) {
  constexpr float kUlps = 4 * 0x1p-23f;   // half as far as rays start from the triangle
  const Vec3 to = box.bounds.center() - piece.middle;
  const float distance = glm::length(to), reach = piece.radius + box.bounds.radius() + kUlps * piece.extent;
  const float above = glm::dot(to, piece.normal);
  if (above < -reach) return;
  if (above < reach && highest(box, piece.normal) <= piece.height + kUlps * piece.extent) return;
  if (!(reach < distance)) return mark_rectangle(Vec2(0), Vec2(1));
  const float sine = reach / distance + kRounding;
  const float chord = std::sqrt(2 - 2 * std::sqrt(std::max(0.0f, 1 - sine * sine))) + kRounding;
  const Vec2 square = disk_to_square(Vec2(Frame(piece.normal).to_local(to / distance)));
  mark_rectangle(square - kSquareOfDisk * chord, square + kSquareOfDisk * chord);
}

}  // namespace photond
