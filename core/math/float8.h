#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#ifdef __SSE2__
#include <immintrin.h>
#endif

#include "core/math/lanes.h"

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

[[gnu::always_inline]] inline Float8 abs8(const Float8& v) {
  return reinterpret_cast<Float8>(reinterpret_cast<Mask8>(v) & 0x7fffffff);
}

/// Of eight that are not negative.
[[gnu::always_inline]] inline Float8 sqrt8(const Float8& v) {
#ifdef __AVX__
  return _mm256_sqrt_ps(v);
#else
  Float8 root;
  for (std::uint32_t k = 0; k < 8; ++k) root[k] = std::sqrt(v[k]);
  return root;
#endif
}

/// With the signs of others.
[[gnu::always_inline]] inline Float8 copysign8(const Float8& v, const Float8& sign) {
  constexpr std::int32_t kSign = std::numeric_limits<std::int32_t>::min();
  return reinterpret_cast<Float8>((reinterpret_cast<Mask8>(v) & ~kSign) | (reinterpret_cast<Mask8>(sign) & kSign));
}

/// table[index], eight times.
[[gnu::always_inline]] inline Float8 lookup8(const float* table, const Mask8& index) {
#ifdef __AVX2__
  return _mm256_i32gather_ps(table, reinterpret_cast<__m256i>(index), sizeof(float));
#else
  Float8 v;
  for (std::uint32_t k = 0; k < 8; ++k) v[k] = table[index[k]];
  return v;
#endif
}

/// Bit k: whether k is set.
[[gnu::always_inline]] inline std::uint32_t bits8(const Mask8& mask) {
#ifdef __AVX__
  return static_cast<std::uint32_t>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
#elif defined(__SSE2__)
  __m128 halves[2];
  std::memcpy(halves, &mask, sizeof halves);
  return static_cast<std::uint32_t>(_mm_movemask_ps(halves[0]) | _mm_movemask_ps(halves[1]) << 4);
#else
  std::uint32_t bits = 0;
  for (std::uint32_t k = 0; k < 8; ++k) bits |= (static_cast<std::uint32_t>(mask[k]) & 1) << k;
  return bits;
#endif
}

/// Writes first + k·step for each bit k that is set of eight, in ascending order; of eight places, those left over hold
/// anything. Returns how many are set. Without branches, which nobody could predict.
[[gnu::always_inline]] inline std::uint32_t put_set8(std::uint32_t bits, std::uint32_t first, std::uint32_t step,
                                                     std::uint32_t* to) {
#ifdef __AVX2__
  const std::uint64_t set = _pext_u64(0x0706050403020100, _pdep_u64(bits, 0x0101010101010101) * 0xff);
  const auto k = reinterpret_cast<Bits8>(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(set))));
  const Bits8 numbers = first + k * step;
  std::memcpy(to, &numbers, sizeof numbers);
  return static_cast<std::uint32_t>(std::popcount(bits));
#else
  std::uint32_t count = 0;
  for (std::uint32_t k = 0; k < 8; ++k) {
    to[count] = first + k * step;
    count += bits >> k & 1;
  }
  return count;
#endif
}

[[gnu::always_inline]] inline bool any8(const Mask8& mask) { return bits8(mask) != 0; }

/// Of all eight.
[[gnu::always_inline]] inline float sum8(const Float8& v) {
  const Float8 half = v + __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3);
  const Float8 quarter = half + __builtin_shufflevector(half, half, 2, 3, 0, 1, 6, 7, 4, 5);
  return quarter[0] + quarter[1];
}

/// The smallest of all eight.
[[gnu::always_inline]] inline float least8(const Float8& v) {
  const Float8 half = min8(v, __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3));
  const Float8 quarter = min8(half, __builtin_shufflevector(half, half, 2, 3, 0, 1, 6, 7, 4, 5));
  return quarter[0] < quarter[1] ? quarter[0] : quarter[1];
}

/// The largest of all eight.
[[gnu::always_inline]] inline float most8(const Float8& v) { return -least8(-v); }

/// Around eight boxes; of points, both corners are the same.
[[gnu::always_inline]] inline Bounds3 bounds8(const Vec3x8& low, const Vec3x8& high) {
  return {{least8(low.x), least8(low.y), least8(low.z)}, {most8(high.x), most8(high.y), most8(high.z)}};
}

[[gnu::always_inline]] inline Vec3x8 operator-(const Vec3& a, const Vec3x8& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[gnu::always_inline]] inline Vec3x8 operator-(const Vec3x8& a, const Vec3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[gnu::always_inline]] inline Vec3x8 operator+(const Vec3x8& a, const Vec3x8& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
[[gnu::always_inline]] inline Vec3x8 operator+(const Vec3x8& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
[[gnu::always_inline]] inline Vec3x8 cross(const Vec3x8& a, const Vec3x8& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
[[gnu::always_inline]] inline Vec3x8 operator*(const Vec3x8& a, const Float8& b) { return {a.x * b, a.y * b, a.z * b}; }
[[gnu::always_inline]] inline Vec3x8 operator*(const Vec3x8& a, const Vec3x8& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
[[gnu::always_inline]] inline Vec3x8 operator*(const Vec3& a, const Float8& b) { return {a.x * b, a.y * b, a.z * b}; }
[[gnu::always_inline]] inline Vec3x8 choose8(const Mask8& mask, const Vec3x8& a, const Vec3x8& b) {
  return {mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z};
}
[[gnu::always_inline]] inline Float8 dot(const Vec3x8& a, const Vec3x8& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
[[gnu::always_inline]] inline Float8 dot(const Vec3& a, const Vec3x8& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

}  // namespace photond
