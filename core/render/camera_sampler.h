#pragma once

#include <cstdint>

#include "core/math/sobol.h"

namespace photond {

/// Consecutive passes whose camera samples are stratified against one another.
inline constexpr std::uint32_t kStratifiedPasses = 16;

/// The random numbers of one pixel in one pass: an Owen-scrambled Sobol sequence over the passes of a block for the
/// first dimensions, independent numbers beyond them. Depends on nothing but its arguments.
class CameraSampler {
 public:
  CameraSampler(std::uint64_t seed, std::uint32_t pass, std::uint64_t pixel)
      : rng_(seed, RngPurpose::camera, pass, pixel),
        key_(mix64(mix64(seed + 0x6a09e667f3bcc909ULL) ^ mix64(pixel * 0x9e3779b97f4a7c15ULL + pass / kStratifiedPasses))),
        index_(pass % kStratifiedPasses) {}

  /// Two numbers that are stratified together.
  Vec2 next2() {
    if (dimension_ == kStratified) return rng_.next2();
    return sobol_2d(index_, key(++dimension_));
  }
  float next() { return dimension_ == kStratified ? rng_.next() : next2().x; }
  /// next2() twice.
  Vec4 next4() {
    if (dimension_ + 2 > kStratified) {
      const Vec2 xy = next2();
      const Vec2 zw = next2();
      return {xy, zw};
    }
    dimension_ += 2;
    return sobol_4d(index_, key(dimension_ - 1), key(dimension_));
  }

 private:
  static constexpr std::uint32_t kStratified = 24;  // pairs
  std::uint64_t key(std::uint32_t dimension) const { return key_ + 0x9e3779b97f4a7c15ULL * dimension; }

  Rng rng_;
  std::uint64_t key_;
  std::uint32_t index_;
  std::uint32_t dimension_ = 0;
};

}  // namespace photond
