#pragma once

#include <bit>
#include <cstdint>

#include "core/math/types.h"

namespace photond {

/// What a random stream is for; streams of different purposes are independent.
enum class RngPurpose : std::uint64_t { photon = 1, camera = 2, pilot = 3 };

/// Finalizer of MurmurHash3: a bijection of 64-bit values with good avalanche.
inline std::uint64_t mix64(std::uint64_t x) {
  x ^= x >> 33;
  x *= 0xff51afd7ed558ccdULL;
  x ^= x >> 33;
  x *= 0xc4ceb9fe1a85ec53ULL;
  return x ^ (x >> 33);
}

/// A PCG32 stream [O'Neill 2014] keyed by (seed, purpose, pass, index): one per emitted path and one per
/// (pixel, pass), never per thread, so that results do not depend on scheduling.
class Rng {
 public:
  Rng(std::uint64_t seed, RngPurpose purpose, std::uint64_t pass, std::uint64_t index) {
    const std::uint64_t key = mix64(seed + 0x9e3779b97f4a7c15ULL * static_cast<std::uint64_t>(purpose));
    const std::uint64_t stream = mix64(key ^ (pass + 0x632be59bd9b4e019ULL));
    increment_ = (stream << 1) | 1;
    state_ = mix64(stream + index * 0x9e3779b97f4a7c15ULL);
    next_uint();
  }

  std::uint32_t next_uint() {
    const std::uint64_t old = state_;
    state_ = old * 6364136223846793005ULL + increment_;
    const auto shifted = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
    return std::rotr(shifted, static_cast<int>(old >> 59));
  }

  /// Uniform in [0, 1).
  float next() { return static_cast<float>(next_uint() >> 8) * 0x1p-24f; }

  Vec2 next2() {
    const float x = next();
    const float y = next();
    return {x, y};
  }

 private:
  std::uint64_t state_;
  std::uint64_t increment_;
};

}  // namespace photond
