#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/features.h"
#include "core/math/alias_table.h"
#include "core/math/frame.h"
#include "core/math/rng.h"
#include "core/math/types.h"
#include "core/math/warp.h"

namespace photond {

/// A place worth aiming at.
struct Ball {
  Vec3 center{0};
  float radius = 0;
};

/// Whether the ray from a point outside of the ball meets it.
inline bool meets(const Ball& ball, const Vec3& point, const Vec3& direction) {
  const Vec3 to_center = ball.center - point, beside = glm::cross(to_center, direction);
  return glm::dot(beside, beside) <= ball.radius * ball.radius && glm::dot(direction, to_center) > 0;
}

/// 1 − cos of the half angle that a ball fills whose centre lies `to_center` away, 2 from inside; precise for far balls,
/// too.
inline float cap_height(const Vec3& to_center, float radius) {
  const float sine_sq = radius * radius / glm::dot(to_center, to_center);
  return choose(sine_sq < 1, sine_sq / (1 + std::sqrt(std::max(0.0f, 1 - sine_sq))), 2);
}

/// A direction towards that ball, uniform over those that meet it.
inline Vec3 square_to_ball(const Vec2& u, const Vec3& to_center, float radius) {
  const float height = cap_height(to_center, radius);
  // Uniform in the cap around +z: heights are to areas as squared distances from a disk's centre are.
  const Vec2 d = square_to_disk(u);
  const float h = glm::dot(d, d) * height;
  const float scale = std::sqrt(height * std::max(0.0f, 2 - h));
  const float distance = std::sqrt(glm::dot(to_center, to_center));
  const Vec3 axis = choose(distance > 0, to_center / std::max(distance, std::numeric_limits<float>::min()), Vec3(0, 0, 1));
  return Frame(axis).to_world({d.x * scale, d.y * scale, 1 - h});
}

/// How a light emits towards balls: some of its paths go to one of them, chosen with fixed probabilities, uniformly
/// over the directions (from a point) or over the disc (along a direction) that the ball fills. The others leave as
/// ever, so that no path is lost: densities are those of the mixture.
class Aim {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;

  /// Aims at nothing.
  Aim() = default;
  /// A `share` of the paths, in (0, 1], goes to the balls in proportion to `weights`.
  Aim(std::span<const Ball> balls, std::span<const double> weights, float share);

  /// Share of the paths that aim.
  float share() const { return kAllFeatures ? share_ : 0; }
  /// Whether a path aims. Takes no random number where none does.
  bool draw(Rng& rng) const { return share() > 0 && rng.next() < share(); }
  /// A ball, by number.
  std::uint32_t choose(float u) const { return choice_.sample(u); }
  const Ball& ball(std::uint32_t number) const { return balls_[number]; }

  /// A direction from `point` towards the ball.
  Vec3 direction(const Vec3& point, std::uint32_t ball, const Vec2& u) const {
    return square_to_ball(u, balls_[ball].center - point, balls_[ball].radius);
  }
  /// Density per solid angle of `direction` over all balls. `drawn`: the ball that the direction was drawn for, which
  /// counts whatever rounding says.
  float pdf_w(const Vec3& point, const Vec3& direction, std::uint32_t drawn = kNone) const;

  /// A point on the disc that faces `direction` through the ball's centre.
  Vec3 place(const Vec3& direction, std::uint32_t ball, const Vec2& u) const;
  /// Density per area across `direction` of the lines through `point` over all balls.
  float pdf_a(const Vec3& point, const Vec3& direction, std::uint32_t drawn = kNone) const;

 private:
  // What densities need of eight balls. Those that are none have no weight.
  struct alignas(32) Eight {
    float x[8], y[8], z[8];
    float radius_sq[8];
    float weight[8];
  };

  float share_ = 0;
  std::vector<Ball> balls_;
  std::vector<Eight> eights_;
  AliasTable choice_;
};

}  // namespace photond
