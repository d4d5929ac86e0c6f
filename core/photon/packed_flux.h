#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "core/math/rng.h"

namespace photond {

/// A non-negative float in 16 bits: eight of exponent and eight of mantissa, so the whole range at 1/256 relative
/// step. A channel does not lose by the size of its neighbours, as it would under a shared exponent.
inline float decode_flux(std::uint16_t bits) { return std::bit_cast<float>(static_cast<std::uint32_t>(bits) << 15); }

/// One of the two neighbours of `value`, the upper one with probability in proportion to the distance from the lower
/// one when `random`'s low 15 bits are uniform: the mean is exactly `value`. Saturates at the largest finite float.
inline std::uint16_t encode_flux(float value, std::uint32_t random) {
  const std::uint32_t bits = std::min(std::bit_cast<std::uint32_t>(value), 0x7f7f8000u);
  return static_cast<std::uint16_t>((bits + (random & 0x7fff)) >> 15);
}

using PackedFlux = std::array<std::uint16_t, 3>;

/// Rounds the three channels with numbers that depend only on `index`.
inline PackedFlux encode_flux(const Rgb& flux, std::uint64_t index) {
  const std::uint64_t random = mix64((index + 1) * 0x9e3779b97f4a7c15ULL);
  return {encode_flux(flux.x, static_cast<std::uint32_t>(random)),
          encode_flux(flux.y, static_cast<std::uint32_t>(random >> 16)),
          encode_flux(flux.z, static_cast<std::uint32_t>(random >> 32))};
}

}  // namespace photond
