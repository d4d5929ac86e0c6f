#include "core/trace/aim.h"

#include "core/math/float8.h"
#include "core/math/frame.h"
#include "core/math/warp.h"

namespace photond {

namespace {

// As cap_height, of eight balls by the squares of their radii and distances.
Float8 cap_height(const Float8& radius_sq, const Float8& distance_sq) {
  const Float8 sine_sq = radius_sq / distance_sq;
  return sine_sq < 1 ? sine_sq / (1 + sqrt8(1 - min8(sine_sq, Float8{} + 1))) : 2;
}

// Whether the line meets each of eight balls. By the cross product: the difference of squares of large distances would
// be noise.
Mask8 meets(const Vec3x8& to_center, const Vec3& direction, const Float8& radius_sq) {
  const Vec3x8 beside = cross(to_center, Vec3x8{Float8{} + direction.x, Float8{} + direction.y, Float8{} + direction.z});
  return dot(beside, beside) <= radius_sq;
}

// Which of the eight from `first` on is the one.
Mask8 is8(std::uint32_t one, std::uint32_t first) {
  constexpr Mask8 kSteps = {0, 1, 2, 3, 4, 5, 6, 7};
  return kSteps == static_cast<std::int32_t>(one - first);
}

}  // namespace

Aim::Aim(std::span<const Ball> balls, std::span<const double> weights, float share)
    : share_(share), balls_(balls.begin(), balls.end()), eights_((balls.size() + 7) / 8), choice_(weights) {
  for (std::size_t i = 0; i < balls.size(); ++i) {
    Eight& eight = eights_[i / 8];
    const std::size_t k = i % 8;
    eight.x[k] = balls[i].center.x;
    eight.y[k] = balls[i].center.y;
    eight.z[k] = balls[i].center.z;
    eight.radius_sq[k] = balls[i].radius * balls[i].radius;
    eight.weight[k] = choice_.pdf(i);
  }
}

Vec3 Aim::place(const Vec3& direction, std::uint32_t ball, const Vec2& u) const {
  const Frame frame(direction);
  const Vec2 d = square_to_disk(u) * balls_[ball].radius;
  return balls_[ball].center + d.x * frame.s + d.y * frame.t;
}

float Aim::pdf_w(const Vec3& point, const Vec3& direction, std::uint32_t drawn) const {
  Float8 pdf{};
  for (std::uint32_t i = 0; i < eights_.size(); ++i) {
    const Eight& eight = eights_[i];
    const Float8 radius_sq = load8(eight.radius_sq), weight = load8(eight.weight);
    const Vec3x8 to_center = Vec3x8{load8(eight.x), load8(eight.y), load8(eight.z)} - point;
    const Float8 distance_sq = dot(to_center, to_center);
    const Mask8 ahead = meets(to_center, direction, radius_sq) & (dot(direction, to_center) > 0);
    const Mask8 found = (ahead | (distance_sq <= radius_sq) | is8(drawn, 8 * i)) & (weight > 0);
    if (!any8(found)) continue;   // as most directions that are not aimed
    const Float8 density = weight / (2 * kPi * cap_height(radius_sq, distance_sq));
    pdf += found ? density : 0;
  }
  return sum8(pdf);
}

float Aim::pdf_a(const Vec3& point, const Vec3& direction, std::uint32_t drawn) const {
  Float8 pdf{};
  for (std::uint32_t i = 0; i < eights_.size(); ++i) {
    const Eight& eight = eights_[i];
    const Float8 radius_sq = load8(eight.radius_sq), weight = load8(eight.weight);
    const Vec3x8 to_center = Vec3x8{load8(eight.x), load8(eight.y), load8(eight.z)} - point;
    const Mask8 found = (meets(to_center, direction, radius_sq) | is8(drawn, 8 * i)) & (weight > 0);
    pdf += found ? weight / (kPi * radius_sq) : 0;
  }
  return sum8(pdf);
}

}  // namespace photond
