#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/math/types.h"

namespace photond {

/// `condition ? a : b` without a branch, for conditions that no branch could predict.
inline float choose(bool condition, float a, float b) {
  const std::uint32_t mask = condition ? 0xffffffffu : 0;
  return std::bit_cast<float>((std::bit_cast<std::uint32_t>(a) & mask) | (std::bit_cast<std::uint32_t>(b) & ~mask));
}

inline Vec3 choose(bool condition, const Vec3& a, const Vec3& b) {
  return {choose(condition, a.x, b.x), choose(condition, a.y, b.y), choose(condition, a.z, b.z)};
}

/// u + shift modulo 1. Exact for multiples of 2⁻²⁴ as random numbers are: a sum beyond 1 would lose the last bit, by which
/// one of many lights is chosen.
inline Vec3 shifted(const Vec3& u, const Vec3& shift) {
  const Vec3 rest = 1.0f - shift;
  return glm::mix(u - rest, u + shift, glm::lessThan(u, rest));
}

/// sin and cos of |x| ≤ π/4 to float precision (Taylor; the terms left out are below 3·10⁻⁸).
inline float sin_eighth(float x) {
  const float s = x * x;
  return x * (1 + s * (-1 / 6.0f + s * (1 / 120.0f + s * (-1 / 5040.0f + s * (1 / 362880.0f)))));
}
inline float cos_eighth(float x) {
  const float s = x * x;
  return 1 + s * (-0.5f + s * (1 / 24.0f + s * (-1 / 720.0f + s * (1 / 40320.0f))));
}

/// atan of 0 ≤ x ≤ 1 to float precision (interpolated in x² at Chebyshev nodes; the error is below 1.2·10⁻⁷).
inline float atan_unit(float x) {
  const float s = x * x;
  return x * (0.99999998f +
              s * (-0.33333037f +
                   s * (0.19991872f +
                        s * (-0.14197798f +
                             s * (0.10618371f +
                                  s * (-0.07456855f + s * (0.04213762f + s * (-0.01573125f + s * 0.00276628f))))))));
}

/// Uniform on the unit disk, area-preserving and continuous [Shirley and Chiu 1997]; density 1/π.
inline Vec2 square_to_disk(const Vec2& u) {
  const float x = 2 * u.x - 1, y = 2 * u.y - 1;
  const float wide = std::abs(x), high = std::abs(y);
  const float r = std::max(std::max(wide, high), std::numeric_limits<float>::min());  // the centre is not 0/0
  const float phi = (kPi / 4) * (std::min(wide, high) / r);
  const float along = r * cos_eighth(phi);
  const float across = r * sin_eighth(phi);
  return {std::copysign(choose(wide > high, along, across), x), std::copysign(choose(wide > high, across, along), y)};
}

/// Its inverse.
inline Vec2 disk_to_square(const Vec2& d) {
  const float wide = std::abs(d.x), high = std::abs(d.y);
  const float most = std::max(std::max(wide, high), std::numeric_limits<float>::min());  // the centre is not 0/0
  const float r = std::sqrt(glm::dot(d, d));
  const float across = r * atan_unit(std::min(wide, high) / most) * (4 / kPi);
  const float x = std::copysign(choose(wide > high, r, across), d.x);
  const float y = std::copysign(choose(wide > high, across, r), d.y);
  return {0.5f + 0.5f * x, 0.5f + 0.5f * y};
}

/// Cosine-distributed on the hemisphere z ≥ 0.
inline Vec3 square_to_cosine_hemisphere(const Vec2& u) {
  const Vec2 d = square_to_disk(u);
  return {d.x, d.y, std::sqrt(std::max(0.0f, 1 - d.x * d.x - d.y * d.y))};
}
/// Its density per solid angle.
inline float square_to_cosine_hemisphere_pdf(const Vec3& w) { return w.z > 0 ? w.z * kInvPi : 0; }

/// Uniform on the unit sphere; density 1/(4π) per solid angle.
inline Vec3 square_to_sphere(const Vec2& u) {
  const float z = 1 - 2 * u.x;
  const float r = std::sqrt(std::max(0.0f, 1 - z * z));
  const float phi = 2 * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}
inline constexpr float kSpherePdf = 1 / (4 * kPi);

/// Uniform in the cone around +z; `height` is 1 − cos of its half angle, which is precise for narrow cones, too.
inline Vec3 square_to_cone(const Vec2& u, float height) {
  const float h = u.x * height;
  const float r = std::sqrt(std::max(0.0f, h * (2 - h)));
  const float phi = 2 * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), 1 - h};
}
/// Its density per solid angle inside the cone.
inline float square_to_cone_pdf(float height) { return 1 / (2 * kPi * height); }

/// Uniform on a triangle: the weights of its second and third vertex; density 1/area.
inline Vec2 square_to_triangle(const Vec2& u) {
  const float root = std::sqrt(u.x);
  return {root * (1 - u.y), root * u.y};
}
/// Its inverse, within [0, 1]².
inline Vec2 triangle_to_square(const Vec2& weights) {
  const float root = std::clamp(weights.x + weights.y, 0.0f, 1.0f);
  return {root * root, root > 0 ? std::clamp(weights.y / root, 0.0f, 1.0f) : 0};
}

}  // namespace photond
