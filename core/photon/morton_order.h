#pragma once

#include <cstdint>
#include <span>

#include "core/base/large_array.h"
#include "core/base/parallel.h"
#include "core/photon/morton_grid.h"
#include "core/photon/photon.h"

namespace photond {

/// Photons in several pieces of memory, one after the other, each of at most PhotonKey::kMaxSpan.
using PhotonSpans = std::span<const std::span<const Photon>>;

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
/// 2²¹ spans. All codes have at least the first `levels` bits of each axis in common.
LargeArray<PhotonKey> morton_order(PhotonSpans photons, const MortonGrid& grid, int levels, const Execution& execution);

}  // namespace photond
