#pragma once

#include <array>

#include "core/math/types.h"

namespace photond {

/// Radii at which one photon gather estimates radiance, each half of the one before.
inline constexpr int kScales = 5;
inline constexpr int kBands = kScales - 1;

/// What the finer radii add to the estimate L_0 of the widest: band j is L_{j+1} − L_j, so that L_0 plus all bands is
/// the estimate of the narrowest radius. Where the photon density is even a band is zero but for noise; its mean
/// elsewhere is bias of the wider radius. Linear: the bands of a sum of pictures are the sums of the bands.
struct Bands {
  std::array<Rgb, kBands> value{};
  std::array<float, kBands> variance{};   ///< of `value` over independent photon maps, summed over RGB
};

}  // namespace photond
