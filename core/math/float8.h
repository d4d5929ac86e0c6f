#pragma once

#include <cstdint>
#include <cstring>

#ifdef __AVX__
#include <immintrin.h>
#endif

#include "core/math/lanes.h"

// All that takes them is inlined, so that it does not matter how they would be passed.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace photond {

/// Eight numbers side by side, what their comparisons say (−1 or 0), eight sets of bits, and eight vectors.
using Float8 = float __attribute__((vector_size(32)));
using Mask8 = std::int32_t __attribute__((vector_size(32)));
using Bits8 = std::uint32_t __attribute__((vector_size(32)));
struct Vec3x8 {
  Float8 x, y, z;
};

[[gnu::always_inline]] inline Float8 load8(const float* from) {
  Float8 v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
[[gnu::always_inline]] inline Vec3x8 load8(const Vec3Lanes& v, std::uint32_t first) {
  return {load8(&v.x[first]), load8(&v.y[first]), load8(&v.z[first])};
}
[[gnu::always_inline]] inline Mask8 load8(const std::uint32_t* from) {
  Mask8 v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
[[gnu::always_inline]] inline void store8(float* to, const Float8& v) { std::memcpy(to, &v, sizeof v); }
[[gnu::always_inline]] inline void store8(std::uint32_t* to, const Mask8& v) { std::memcpy(to, &v, sizeof v); }

[[gnu::always_inline]] inline Float8 min8(const Float8& a, const Float8& b) { return a < b ? a : b; }
[[gnu::always_inline]] inline Float8 max8(const Float8& a, const Float8& b) { return a > b ? a : b; }

/// Bit k: whether k is set.
[[gnu::always_inline]] inline std::uint32_t bits8(const Mask8& mask) {
#ifdef __AVX__
  return static_cast<std::uint32_t>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
#else
  std::uint32_t bits = 0;
  for (std::uint32_t k = 0; k < 8; ++k) bits |= (static_cast<std::uint32_t>(mask[k]) & 1) << k;
  return bits;
#endif
}

[[gnu::always_inline]] inline Vec3x8 operator-(const Vec3& a, const Vec3x8& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[gnu::always_inline]] inline Vec3x8 cross(const Vec3x8& a, const Vec3x8& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
[[gnu::always_inline]] inline Vec3x8 operator*(const Vec3x8& a, const Float8& b) { return {a.x * b, a.y * b, a.z * b}; }
[[gnu::always_inline]] inline Float8 dot(const Vec3x8& a, const Vec3x8& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
[[gnu::always_inline]] inline Float8 dot(const Vec3& a, const Vec3x8& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

}  // namespace photond

#pragma GCC diagnostic pop
