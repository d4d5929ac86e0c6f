#pragma once

#include <cstddef>
#include <cstdint>

#include "core/math/types.h"

namespace photond {

/// Values of this many walks lie side by side (structure of arrays), so that the compiler computes several at a time.
/// Functions used on them have no branches.
inline constexpr std::uint32_t kLanes = 32;
/// Where a loop over `count` lanes ends: it computes whole vectors, the last of them partly for nothing.
inline std::uint32_t whole_vectors(std::uint32_t count) { return (count + 7) & ~7u; }

struct Vec3Lanes {
  float x[kLanes], y[kLanes], z[kLanes];

  Vec3 operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
  void set(std::size_t i, const Vec3& v) {
    x[i] = v.x;
    y[i] = v.y;
    z[i] = v.z;
  }
};

}  // namespace photond
