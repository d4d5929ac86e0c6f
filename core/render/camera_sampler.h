#pragma once

#include <cstdint>

#include "core/math/lanes.h"
#include "core/math/sobol.h"

namespace photond {

/// Consecutive passes whose camera samples are stratified against one another.
inline constexpr std::uint32_t kStratifiedPasses = 16;

/// The random numbers of one pixel in one pass: pairs from Owen-scrambled Sobol sequences over the passes of a block.
/// Depends on nothing but its arguments.
class CameraSampler {
 public:
  CameraSampler() = default;
  CameraSampler(std::uint64_t seed, std::uint32_t pass, std::uint64_t pixel)
      : CameraSampler(pass % kStratifiedPasses, mix64(mix64(seed + 0x6a09e667f3bcc909ULL) ^ mix64(pixel * 0x9e3779b97f4a7c15ULL + pass / kStratifiedPasses))) {}

  /// Two numbers that are stratified together.
  Vec2 next2() { return sobol_2d(index_, seed(++dimension_)); }
  float next() { return next2().x; }
  /// next2() twice.
  Vec4 next4() {
    dimension_ += 2;
    return sobol_4d(index_, seed(dimension_ - 1), seed(dimension_));
  }

  /// Other numbers, for a path that leaves this one here.
  CameraSampler branch() {
    const std::uint64_t key = static_cast<std::uint64_t>(high_) << 32 | low_;
    return {index_, mix64(key + 0x9e3779b97f4a7c15ULL * ++dimension_)};
  }

 private:
  friend struct SamplerLanes;
  CameraSampler(std::uint32_t index, std::uint64_t key)
      : index_(index), low_(static_cast<std::uint32_t>(key)), high_(static_cast<std::uint32_t>(key >> 32)) {}

  static std::uint32_t seed(std::uint32_t low, std::uint32_t high, std::uint32_t dimension) {
    return mix32(low + 0x9e3779b9u * dimension) ^ high;
  }
  std::uint32_t seed(std::uint32_t dimension) const { return seed(low_, high_, dimension); }

  std::uint32_t index_ = 0;
  std::uint32_t low_ = 0, high_ = 0;   // halves of a key
  std::uint32_t dimension_ = 0;
};

/// The numbers of several samplers.
struct alignas(64) SamplerLanes {
  std::uint32_t index[kLanes], low[kLanes], high[kLanes], dimension[kLanes];

  /// Fills lane k with what the sampler returns next, and lets it skip the `pairs` that will be drawn here.
  void set(std::uint32_t k, CameraSampler& sampler, std::uint32_t pairs) {
    set(k, sampler);
    sampler.dimension_ += pairs;
  }
  void set(std::uint32_t k, const CameraSampler& sampler) {
    index[k] = sampler.index_;
    low[k] = sampler.low_;
    high[k] = sampler.high_;
    dimension[k] = sampler.dimension_;
  }
  /// The sampler of lane k as it is now.
  CameraSampler sampler(std::uint32_t k) const {
    CameraSampler sampler;
    sampler.index_ = index[k];
    sampler.low_ = low[k];
    sampler.high_ = high[k];
    sampler.dimension_ = dimension[k];
    return sampler;
  }
  /// Copies a lane.
  void copy(std::uint32_t from, std::uint32_t to) {
    index[to] = index[from];
    low[to] = low[from];
    high[to] = high[from];
    dimension[to] = dimension[from];
  }
  /// CameraSampler::next2 of the first `count` lanes.
  void next2(std::uint32_t count, float (&x)[kLanes], float (&y)[kLanes]);
};

}  // namespace photond
