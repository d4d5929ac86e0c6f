#pragma once

#include <cstdint>
#include <span>

#ifdef __BMI2__
#include <immintrin.h>
#endif

#include "core/base/large_array.h"
#include "core/base/parallel.h"
#include "core/photon/photon.h"

namespace photond {

/// Photons in several pieces of memory, one after the other, each of at most PhotonKey::kMaxSpan.
using PhotonSpans = std::span<const std::span<const Photon>>;

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
    return spread(coordinate(cell.x)) << 2 | spread(coordinate(cell.y)) << 1 | spread(coordinate(cell.z));
  }
  /// Its first nine bits: the number of the cube of 2¹⁸ cells an axis that it is in.
  std::uint32_t cube(const Vec3& p) const {
    return static_cast<std::uint32_t>(code(p) >> (3 * kAxisBits - 9));
  }
  static constexpr std::uint32_t kCubes = 512;
  /// Where a cube is among the eight of each axis.
  static Vec3 cube_position(std::uint32_t cube) {
    const auto axis = [cube](int first) {
      return static_cast<float>((cube >> first & 1) | (cube >> (first + 3) & 1) << 1 | (cube >> (first + 6) & 1) << 2);
    };
    return {axis(2), axis(1), axis(0)};
  }

 private:
  static constexpr std::int32_t kCells = 1 << kAxisBits;

  // Written so that no branch is needed.
  static std::uint32_t coordinate(float v) {
    constexpr auto kLast = static_cast<float>(kCells - 1);
    const float above = v > 0 ? v : 0;
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(above < kLast ? above : kLast));
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

  Vec3 min_{0};
  float scale_ = 0;
};

/// A photon among others: where it stands, and above that what is sorted by.
struct PhotonKey {
  static constexpr int kOffsetBits = 11;   // within a span
  static constexpr std::size_t kMaxSpan = std::size_t{1} << kOffsetBits;

  std::uint64_t bits;

  const Photon& of(PhotonSpans photons) const {
    const auto place = static_cast<std::uint32_t>(bits);
    return photons[place >> kOffsetBits][place & (kMaxSpan - 1)];
  }
};

/// All photons along the grid's curve; those of one cell, or at most 32 so close that 31 bits do not tell them apart from
/// the rest, as they stand. So the result does not depend on the execution. Undefined once that is cancelled. At most
/// 2²¹ spans.
LargeArray<PhotonKey> morton_order(PhotonSpans photons, const MortonGrid& grid, const Execution& execution);

}  // namespace photond
