#pragma once

#include <cmath>
#include <cstdint>

#include "core/math/float8.h"

namespace photond {

/// A unit vector in 16 + 16 bits by the octahedral map [Cigolle et al. 2014]; error below .004°.
inline std::uint32_t encode_direction(const Vec3& w) {
  const float scale = 1 / (std::abs(w.x) + std::abs(w.y) + std::abs(w.z));
  float x = w.x * scale;
  float y = w.y * scale;
  const float fold = std::max(-w.z * scale, 0.0f);  // 1 − |x| − |y| of the lower half
  x += std::copysign(fold, x);
  y += std::copysign(fold, y);
  const auto quantize = [](float v) { return static_cast<std::int32_t>((v * 0.5f + 0.5f) * 65535.0f + 0.5f); };
  return static_cast<std::uint32_t>(quantize(x) | quantize(y) << 16);
}

/// The direction at an arbitrary length.
inline Vec3 octahedral_vector(std::uint32_t bits) {
  const float x = static_cast<float>(bits & 0xffff) * (2 / 65535.0f) - 1;
  const float y = static_cast<float>(bits >> 16) * (2 / 65535.0f) - 1;
  Vec3 w{x, y, 1 - std::abs(x) - std::abs(y)};
  const float fold = std::max(-w.z, 0.0f);
  w.x -= std::copysign(fold, w.x);
  w.y -= std::copysign(fold, w.y);
  return w;
}
inline Vec3 decode_direction(std::uint32_t bits) { return glm::normalize(octahedral_vector(bits)); }
/// Of eight.
[[gnu::always_inline]] inline Vec3x8 decode_direction(const Bits8& bits) {
  const auto value = [](const Bits8& v) __attribute__((always_inline)) {
    return __builtin_convertvector(reinterpret_cast<Mask8>(v), Float8) * (2 / 65535.0f) - 1;
  };
  const Float8 x = value(bits & 0xffff), y = value(bits >> 16);
  const Float8 z = 1 - abs8(x) - abs8(y);
  const Float8 fold = max8(-z, Float8{});
  const Vec3x8 w{x - copysign8(fold, x), y - copysign8(fold, y), z};
  return w * (1 / sqrt8(dot(w, w)));
}

/// A unit vector in three times ten bits: for tests of orientation only; error below .1°.
inline std::uint32_t encode_normal(const Vec3& n) {
  const auto quantize = [](float v) { return static_cast<std::int32_t>((v + 1) * 511.0f + 0.5f); };
  return static_cast<std::uint32_t>(quantize(n.x) | quantize(n.y) << 10 | quantize(n.z) << 20);
}
/// Its length is 1 to .2 %.
inline Vec3 decode_normal(std::uint32_t bits) {
  const auto value = [](std::uint32_t v) { return static_cast<float>(v & 1023) * (1 / 511.0f) - 1; };
  return {value(bits), value(bits >> 10), value(bits >> 20)};
}
/// Of eight.
[[gnu::always_inline]] inline Vec3x8 decode_normal(const Bits8& bits) {
  const auto value = [](const Bits8& v) __attribute__((always_inline)) {
    return __builtin_convertvector(reinterpret_cast<Mask8>(v & 1023), Float8) * (1 / 511.0f) - 1;
  };
  return {value(bits), value(bits >> 10), value(bits >> 20)};
}

}  // namespace photond
