#pragma once

#include "core/math/float8.h"

namespace photond {

/// Logarithms to base 2 of eight normal numbers above 0, to float precision.
[[gnu::always_inline]] inline Float8 log2_8(const Float8& v) {
  // v = 2^n·m with m in [√½, √2); ln m = 2 artanh((m − 1)/(m + 1)), whose series ends below float precision.
  constexpr std::int32_t kRootHalf = 0x3f3504f3, kMantissa = 0x7fffff;
  const Mask8 bits = reinterpret_cast<Mask8>(v) - kRootHalf;
  const Float8 m = reinterpret_cast<Float8>((bits & kMantissa) + kRootHalf);
  const Float8 t = (m - 1) / (m + 1), s = t * t;
  const Float8 series = 1 + s * (1 / 3.0f + s * (1 / 5.0f + s * (1 / 7.0f + s * (1 / 9.0f))));
  constexpr float kTwoOverLn2 = 2.8853900818f;
  return __builtin_convertvector(bits >> 23, Float8) + kTwoOverLn2 * t * series;
}

/// 2 to the power of eight numbers, to float precision; those beyond ±126 are taken as that.
[[gnu::always_inline]] inline Float8 exp2_8(const Float8& v) {
  const Float8 x = min8(max8(v, Float8{} - 126), Float8{} + 126);
  const Mask8 n = __builtin_convertvector(x + copysign8(Float8{} + 0.5f, x), Mask8);
  constexpr float kLn2 = 0.6931471806f;
  const Float8 y = (x - __builtin_convertvector(n, Float8)) * kLn2;   // |y| ≤ ½ ln 2
  const Float8 end = 1 / 24.0f + y * (1 / 120.0f + y * (1 / 720.0f + y * (1 / 5040.0f)));
  const Float8 series = 1 + y * (1 + y * (1 / 2.0f + y * (1 / 6.0f + y * end)));
  return series * reinterpret_cast<Float8>((n + 127) << 23);
}

}  // namespace photond
