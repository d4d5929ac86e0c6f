#include "core/trace/aim.h"

#include <cmath>

#include "core/math/frame.h"
#include "core/math/warp.h"

namespace photond {

namespace {

// 1 − cos of the half angle that a ball fills, 2 from inside; precise for far balls, too.
float cap_height(const Vec3& to_center, float radius) {
  const float sine_sq = radius * radius / glm::dot(to_center, to_center);
  return sine_sq < 1 ? sine_sq / (1 + std::sqrt(1 - sine_sq)) : 2;
}

// Uniform in the cap of that height around +z.
Vec3 square_to_cap(const Vec2& u, float height) {
  const float h = u.x * height;
  const float r = std::sqrt(std::max(0.0f, h * (2 - h)));
  const float phi = 2 * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), 1 - h};
}

}  // namespace

Aim::Aim(std::span<const Ball> balls, std::span<const double> weights, float share)
    : share_(share), balls_(balls.begin(), balls.end()), choice_(weights) {}

Vec3 Aim::direction(const Vec3& point, std::uint32_t ball, const Vec2& u) const {
  const Vec3 to_center = balls_[ball].center - point;
  const float distance_sq = glm::dot(to_center, to_center);
  const Vec3 axis = distance_sq > 0 ? to_center / std::sqrt(distance_sq) : Vec3(0, 0, 1);
  return Frame(axis).to_world(square_to_cap(u, cap_height(to_center, balls_[ball].radius)));
}

Vec3 Aim::place(const Vec3& direction, std::uint32_t ball, const Vec2& u) const {
  const Frame frame(direction);
  const Vec2 d = square_to_disk(u) * balls_[ball].radius;
  return balls_[ball].center + d.x * frame.s + d.y * frame.t;
}

template <class Density>
float Aim::sum(const Vec3& point, const Vec3& direction, std::uint32_t drawn, bool forward,
               const Density& density) const {
  float pdf = 0;
  for (std::uint32_t i = 0; i < balls_.size(); ++i) {
    const Vec3 to_center = balls_[i].center - point;
    const float radius_sq = balls_[i].radius * balls_[i].radius;
    // By the cross product: the difference of squares of large distances would be noise.
    const Vec3 beside = glm::cross(to_center, direction);
    const bool ahead = !forward || glm::dot(to_center, direction) > 0;
    const bool inside = forward && glm::dot(to_center, to_center) <= radius_sq;
    if (i != drawn && !inside && !(ahead && glm::dot(beside, beside) <= radius_sq)) continue;
    pdf += choice_.pdf(i) * density(balls_[i], to_center);
  }
  return pdf;
}

float Aim::pdf_w(const Vec3& point, const Vec3& direction, std::uint32_t drawn) const {
  return sum(point, direction, drawn, true, [](const Ball& ball, const Vec3& to_center) {
    return 1 / (2 * kPi * cap_height(to_center, ball.radius));
  });
}

float Aim::pdf_a(const Vec3& point, const Vec3& direction, std::uint32_t drawn) const {
  return sum(point, direction, drawn, false,
             [](const Ball& ball, const Vec3&) { return kInvPi / (ball.radius * ball.radius); });
}

}  // namespace photond
