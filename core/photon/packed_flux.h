#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "core/math/float8.h"
#include "core/math/rng.h"

namespace photond {

/// A non-negative float (−0 is 0) in 16 bits: eight of exponent and eight of mantissa, so the whole range at 1/256 relative
/// step. A channel does not lose by the size of its neighbours, as it would under a shared exponent.
inline float decode_flux(std::uint16_t bits) { return std::bit_cast<float>(static_cast<std::uint32_t>(bits) << 15); }
/// Of eight.
[[gnu::always_inline]] inline Float8 decode_flux(const std::array<std::uint16_t, 8>& bits) {
  using Half8 = std::uint16_t __attribute__((vector_size(16)));
  Half8 v;
  std::memcpy(&v, bits.data(), sizeof v);
  return reinterpret_cast<Float8>(__builtin_convertvector(v, Bits8) << 15);
}

/// One of the two neighbours of `value`, the upper one with probability in proportion to the distance from the lower
/// one when `random`'s low 15 bits are uniform: the mean is exactly `value`. Saturates at the largest finite float.
inline std::uint16_t encode_flux(float value, std::uint32_t random) {
  const std::uint32_t bits = std::min(std::bit_cast<std::uint32_t>(value) & 0x7fffffffu, 0x7f7f8000u);
  return static_cast<std::uint16_t>((bits + (random & 0x7fff)) >> 15);
}

/// Three channels.
struct PackedFlux {
  std::uint32_t red_green = 0;   ///< red below
  std::uint32_t blue = 0;

  static PackedFlux of(std::uint32_t red, std::uint32_t green, std::uint32_t blue) { return {red | green << 16, blue}; }
  std::uint16_t operator[](int channel) const {
    return static_cast<std::uint16_t>(channel == 2 ? blue : red_green >> (16 * channel));
  }
};

/// Rounds the three channels with numbers that depend only on `key`.
inline PackedFlux encode_flux(const Rgb& flux, std::uint32_t key) {
  const std::uint32_t random = mix32(key), more = mix32(random + 0x9e3779b9u);
  return PackedFlux::of(encode_flux(flux.x, random), encode_flux(flux.y, random >> 15), encode_flux(flux.z, more));
}

/// Rounds to the nearest.
inline PackedFlux nearest_flux(const Rgb& flux) {
  constexpr std::uint32_t kHalf = 1 << 14;
  return PackedFlux::of(encode_flux(flux.x, kHalf), encode_flux(flux.y, kHalf), encode_flux(flux.z, kHalf));
}

}  // namespace photond
