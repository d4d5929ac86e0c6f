#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#ifdef __BMI2__
#include <immintrin.h>
#endif

#include "core/base/large_array.h"
#include "core/base/parallel.h"
#include "core/photon/photon.h"

namespace photond {

/// Photons in several pieces of memory, one after the other.
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
    static constexpr std::uint32_t kSpread[8] = {0, 1, 8, 9, 64, 65, 72, 73};   // two zero bits between any two
    const Vec3 cell = (p - min_) * scale_;
    const auto spread = [](float v) { return kSpread[coordinate(v) >> (kAxisBits - 3)]; };
    return spread(cell.x) << 2 | spread(cell.y) << 1 | spread(cell.z);
  }
  static constexpr std::uint32_t kCubes = 512;

 private:
  static constexpr std::int32_t kCells = 1 << kAxisBits;

  static std::uint32_t coordinate(float v) {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::clamp(v, 0.0f, static_cast<float>(kCells - 1))));
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

/// Where a photon stands.
struct PhotonPlace {
  std::uint64_t code;      ///< of its position
  std::uint32_t block;
  std::uint32_t offset;    ///< within the block
};

/// The places of all photons (the blocks' sizes in sum) along the Morton curve; photons of one cell in the order of
/// the blocks, so the result does not depend on the execution. Undefined once `execution` is cancelled.
LargeArray<PhotonPlace> morton_order(PhotonSpans blocks, const MortonGrid& grid, const Execution& execution);

}  // namespace photond
