#pragma once

#include <cstdint>

#include "core/math/rng.h"

namespace photond {

/// A permutation of [0, 2³²) in which each bit depends on the lower bits only: Owen's nested uniform scrambling of
/// a radical inverse whose bits are reversed [Laine and Karras 2011, with the constants of Vegdahl 2021].
inline std::uint32_t scramble_reversed(std::uint32_t x, std::uint32_t seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

inline std::uint32_t reverse_bits(std::uint32_t x) {
  x = __builtin_bswap32(x);
  x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
  x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
  return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
}

/// The second coordinate of the Sobol sequence with its bits reversed: Pascal's triangle modulo 2 times the index.
inline std::uint32_t sobol_y_reversed(std::uint32_t index) {
  index ^= (index >> 1) & 0x55555555u;
  index ^= (index >> 2) & 0x33333333u;
  index ^= (index >> 4) & 0x0f0f0f0fu;
  index ^= (index >> 8) & 0x00ff00ffu;
  return index ^ ((index >> 16) & 0x0000ffffu);
}

/// Sample `index` of an Owen-scrambled (0,2)-sequence [Burley 2020]: uniform in [0, 1)²; every 2^k samples from a
/// multiple of 2^k on have one point in each elementary interval of area 2^−k. Sequences of other seeds are
/// independent, in their order too, so that several of them make a sample of more dimensions.
inline Vec2 sobol_2d(std::uint32_t index, std::uint64_t seed) {
  const std::uint64_t second = mix64(seed);
  // Scrambling an index from its high bits down keeps blocks of 2^k together.
  const std::uint32_t shuffled =
      reverse_bits(scramble_reversed(reverse_bits(index), static_cast<std::uint32_t>(seed >> 32)));
  const std::uint32_t x = reverse_bits(scramble_reversed(shuffled, static_cast<std::uint32_t>(second)));
  const std::uint32_t y =
      reverse_bits(scramble_reversed(sobol_y_reversed(shuffled), static_cast<std::uint32_t>(second >> 32)));
  return {static_cast<float>(x >> 8) * 0x1p-24f, static_cast<float>(y >> 8) * 0x1p-24f};
}

}  // namespace photond
