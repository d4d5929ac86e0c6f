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

/// The same of 32-bit values [Wellons 2018].
inline std::uint32_t mix32(std::uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

/// What all random streams of one pass have in common.
struct RngKey {
  RngKey(std::uint64_t seed, RngPurpose purpose, std::uint64_t pass)
      : bits(mix64(mix64(seed + 0x9e3779b97f4a7c15ULL * static_cast<std::uint64_t>(purpose)) ^
                   (pass + 0x632be59bd9b4e019ULL))) {}
  std::uint64_t bits;
};

/// A PCG32 stream [O'Neill 2014] keyed by (seed, purpose, pass, index): one per emitted path and one per
/// (pixel, pass), never per thread, so that results do not depend on scheduling.
class Rng {
 public:
  Rng(const RngKey& key, std::uint64_t index)
      : state_(mix64(key.bits + index * 0x9e3779b97f4a7c15ULL)), increment_((key.bits << 1) | 1) {
    next_uint();
  }
  Rng(std::uint64_t seed, RngPurpose purpose, std::uint64_t pass, std::uint64_t index)
      : Rng(RngKey(seed, purpose, pass), index) {}

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
