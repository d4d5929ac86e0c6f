#pragma once

#include <cstdint>

#ifdef __BMI2__
#include <immintrin.h>
#endif

#include "core/math/float8.h"

namespace photond {

/// Cells of a cube around `bounds`, 2²¹ an axis, numbered along the Morton curve. They are cubes: of flat ones,
/// neighbours along the curve would be far apart.
class MortonGrid {
 public:
  static constexpr int kAxisBits = 21;

  MortonGrid() = default;
  explicit MortonGrid(const Bounds3& bounds) : min_(bounds.min) {
    const float extent = max_component(bounds.extent());
    scale_ = extent > 0 && extent < kInfinity ? static_cast<float>(kCells) / extent : 0;
  }

  /// The cell's number; for points outside, that of the nearest cell.
  std::uint64_t code(const Vec3& p) const {
    const Vec3 cell = (p - min_) * scale_;
    return number(coordinate(cell.x), coordinate(cell.y), coordinate(cell.z));
  }
  /// Its kPartBits bits that follow the first `levels` bits of each axis.
  static std::uint32_t part(std::uint64_t code, int levels) {
    return static_cast<std::uint32_t>(code << (64 - 3 * kAxisBits + 3 * levels) >> (64 - kPartBits));
  }
  static constexpr int kPartBits = 31;
  /// Of eight points.
  [[gnu::always_inline]] Bits8 parts(const Vec3x8& p, int levels) const {
    const int before = 32 - kAxisBits + levels;
    const Bits8 x = coordinate((p.x - min_.x) * scale_) << before >> 21;    // eleven bits
    const Bits8 y = coordinate((p.y - min_.y) * scale_) << before >> 22;
    const Bits8 z = coordinate((p.z - min_.z) * scale_) << before >> 22;
    return spread(x) | spread(y) << 2 | spread(z) << 1;
  }

  /// Its first kCubeBits bits: the number of the cube of 2¹⁸ cells an axis that it is in.
  std::uint32_t cube(const Vec3& p) const {
    return static_cast<std::uint32_t>(code(p) >> (3 * kAxisBits - kCubeBits));
  }
  static constexpr int kCubeLevels = 3;
  static constexpr int kCubeBits = 3 * kCubeLevels;
  static constexpr std::uint32_t kCubes = 1u << kCubeBits;
  /// Where a cube is among the eight of each axis.
  static Vec3 cube_position(std::uint32_t cube) {
    const auto axis = [cube](int first) {
      return static_cast<float>((cube >> first & 1) | (cube >> (first + 3) & 1) << 1 | (cube >> (first + 6) & 1) << 2);
    };
    return {axis(2), axis(1), axis(0)};
  }

 private:
  static constexpr std::int32_t kCells = 1 << kAxisBits;
  static constexpr auto kLast = static_cast<float>(kCells - 1);

  static std::uint32_t coordinate(float v) {
    const float above = v > 0 ? v : 0;
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(above < kLast ? above : kLast));
  }
  [[gnu::always_inline]] static Bits8 coordinate(const Float8& v) {
    return reinterpret_cast<Bits8>(__builtin_convertvector(min8(max8(v, Float8{}), kLast + Float8{}), Mask8));
  }

  static std::uint64_t number(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return spread(x) << 2 | spread(y) << 1 | spread(z);
  }

  // Two zero bits between any two.
  static std::uint64_t spread(std::uint64_t v) {
#ifdef __BMI2__
    return _pdep_u64(v, 0x1249249249249249ULL);
#endif
    v = (v | v << 32) & 0x1f00000000ffffULL;
    v = (v | v << 16) & 0x1f0000ff0000ffULL;
    v = (v | v << 8) & 0x100f00f00f00f00fULL;
    v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
    return (v | v << 2) & 0x1249249249249249ULL;
  }

  // The same of eleven bits.
  [[gnu::always_inline]] static Bits8 spread(const Bits8& bits) {
    Bits8 v = (bits | bits << 16) & 0x070000ffu;
    v = (v | v << 8) & 0x0700f00fu;
    v = (v | v << 4) & 0x430c30c3u;
    return (v | v << 2) & 0x49249249u;
  }

  Vec3 min_{0};
  float scale_ = 0;

  friend bool operator==(const MortonGrid&, const MortonGrid&) = default;
};

}  // namespace photond
