#pragma once

#include <cstdint>

#include "core/math/rng.h"

namespace photond {

/// Four words computed with side by side; the functions below take one word or four.
using Word4 = std::uint32_t __attribute__((vector_size(16)));

/// A permutation of [0, 2³²) in which each bit depends on the lower bits only: Owen's nested uniform scrambling of
/// a radical inverse whose bits are reversed [Laine and Karras 2011, with the constants of Vegdahl 2021].
template <class Word>
Word scramble_reversed(Word x, Word seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

inline std::uint32_t swap_bytes(std::uint32_t x) { return __builtin_bswap32(x); }
inline Word4 swap_bytes(Word4 x) {
  using Byte16 = std::uint8_t __attribute__((vector_size(16)));
  constexpr Byte16 kOrder = {3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12};
  return reinterpret_cast<Word4>(__builtin_shuffle(reinterpret_cast<Byte16>(x), kOrder));
}

template <class Word>
Word reverse_bits(Word x) {
  x = swap_bytes(x);
  x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
  x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
  return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
}

/// The second coordinate of the Sobol sequence with its bits reversed: Pascal's triangle modulo 2 times the index.
template <class Word>
Word sobol_y_reversed(Word index) {
  index ^= (index >> 1) & 0x55555555u;
  index ^= (index >> 2) & 0x33333333u;
  index ^= (index >> 4) & 0x0f0f0f0fu;
  index ^= (index >> 8) & 0x00ff00ffu;
  return index ^ ((index >> 16) & 0x0000ffffu);
}

/// What scrambles a two-dimensional sequence.
struct SobolKeys {
  std::uint32_t order, x, y;

  explicit SobolKeys(std::uint32_t seed)
      : order(mix32(seed)), x(mix32(seed + 0x68bc21ebu)), y(mix32(seed + 0x02e5be93u)) {}
};

inline float unit_interval(std::uint32_t bits) { return static_cast<float>(static_cast<std::int32_t>(bits >> 8)) * 0x1p-24f; }

/// Sample `index` of an Owen-scrambled (0,2)-sequence [Burley 2020]: uniform in [0, 1)²; every 2^k samples from a
/// multiple of 2^k on have one point in each elementary interval of area 2^−k. Sequences of other seeds are
/// independent, in their order too, so that several of them make a sample of more dimensions.
[[gnu::always_inline]] inline Vec2 sobol_2d(std::uint32_t index, std::uint32_t seed) {
  const SobolKeys keys(seed);
  // Scrambling an index from its high bits down keeps blocks of 2^k together.
  const std::uint32_t shuffled = reverse_bits(scramble_reversed(reverse_bits(index), keys.order));
  const std::uint32_t x = reverse_bits(scramble_reversed(shuffled, keys.x));
  const std::uint32_t y = reverse_bits(scramble_reversed(sobol_y_reversed(shuffled), keys.y));
  return {unit_interval(x), unit_interval(y)};
}

/// sobol_2d(index, seed_xy) and sobol_2d(index, seed_zw), in little more time than one of them.
inline Vec4 sobol_4d(std::uint32_t index, std::uint32_t seed_xy, std::uint32_t seed_zw) {
  const SobolKeys xy(seed_xy), zw(seed_zw);
  const std::uint32_t reversed = reverse_bits(index);
  const Word4 shuffled = reverse_bits(scramble_reversed(Word4{reversed, reversed, reversed, reversed},
                                                        Word4{xy.order, xy.order, zw.order, zw.order}));
  const Word4 y = sobol_y_reversed(shuffled);
  const Word4 sample = reverse_bits(
      scramble_reversed(Word4{shuffled[0], y[1], shuffled[2], y[3]}, Word4{xy.x, xy.y, zw.x, zw.y}));
  return {unit_interval(sample[0]), unit_interval(sample[1]), unit_interval(sample[2]), unit_interval(sample[3])};
}

}  // namespace photond
