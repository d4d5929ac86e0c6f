#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>

#include "core/math/float8.h"
#include "core/photon/morton_grid.h"
#include "core/photon/photon.h"

namespace photond {

static_assert(sizeof(Photon) == sizeof(Mask8) && offsetof(Photon, position) == 0 && offsetof(Photon, direction) == 12 &&
              offsetof(Photon, normal) == 16 && offsetof(Photon, flux) == 20 && offsetof(Photon, etendue) == 28);

/// At once, where the compiler would take member by member.
[[gnu::always_inline]] inline void copy(const Photon& from, Photon& to) {
  static_assert(std::is_trivially_copyable_v<Photon>);
  Mask8 all;
  std::memcpy(&all, &from, sizeof all);
  std::memcpy(static_cast<void*>(&to), &all, sizeof all);
}

/// Of two vectors, what stands where a place's bit `step` is not set, and where it is: a step of a transposition.
[[gnu::always_inline]] inline void exchange(std::size_t step, Mask8& a, Mask8& b) {
  const Mask8 low = step == 1   ? Mask8{0, 8, 2, 10, 4, 12, 6, 14}
                    : step == 2 ? Mask8{0, 1, 8, 9, 4, 5, 12, 13}
                                : Mask8{0, 1, 2, 3, 8, 9, 10, 11};
  const Mask8 from = a;
  a = __builtin_shuffle(from, b, low);
  b = __builtin_shuffle(from, b, low + static_cast<std::int32_t>(step));
}

/// Eight photons component by component, in the order of Photon's members.
[[gnu::always_inline]] inline std::array<Mask8, 8> transposed(const std::array<const Photon*, 8>& photons) {
  std::array<Mask8, 8> m;
  for (std::size_t k = 0; k < 8; ++k) std::memcpy(&m[k], photons[k], sizeof m[k]);
  for (const std::size_t i : {0, 2, 4, 6}) exchange(1, m[i], m[i + 1]);
  for (const std::size_t i : {0, 1, 4, 5}) exchange(2, m[i], m[i + 2]);
  for (const std::size_t i : {0, 1, 2, 3}) exchange(4, m[i], m[i + 4]);
  return m;
}

/// The positions of eight photons one after the other.
[[gnu::always_inline]] inline Vec3x8 positions(const Photon* photons) {
  using Mask4 = std::int32_t __attribute__((vector_size(16)));
  std::array<Mask8, 4> m;
  for (std::size_t k = 0; k < 4; ++k) {
    Mask4 a, b;
    std::memcpy(&a, &photons[k], sizeof a);
    std::memcpy(&b, &photons[k + 4], sizeof b);
    m[k] = __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
  }
  for (const std::size_t i : {0, 2}) exchange(1, m[i], m[i + 1]);
  for (const std::size_t i : {0, 1}) exchange(2, m[i], m[i + 2]);
  return {reinterpret_cast<Float8>(m[0]), reinterpret_cast<Float8>(m[1]), reinterpret_cast<Float8>(m[2])};
}

/// Calls body(photon, MortonGrid::part of its code) for all of them, one after the other.
template <class Body>
void for_parts(std::span<const Photon> photons, const MortonGrid& grid, int levels, const Body& body) {
  const Photon* photon = photons.data();
  const Photon* const end = photon + photons.size();
  for (; end - photon >= 8; photon += 8) {
    const Bits8 parts = grid.parts(positions(photon), levels);
    for (std::size_t k = 0; k < 8; ++k) body(photon[k], parts[k]);
  }
  for (; photon < end; ++photon) body(*photon, MortonGrid::part(grid.code(photon->position), levels));
}

}  // namespace photond
