#pragma once

#include <algorithm>
#include <cstdint>

namespace photond {

/// Probability that a path goes on after a bounce that keeps the fraction `kept` of its weight. Never above 1; a
/// lossless path of hundreds of bounces is slowly thinned, so that light caught in a mirror box ends without a cut
/// while a thousand total reflections in a glass rod still arrive.
inline float survival_probability(float kept, std::uint32_t depth) {
  static constexpr std::uint32_t kLongPath = 128;
  static constexpr float kLongSurvival = 0.999f;
  return std::min(kept, depth < kLongPath ? 1.0f : kLongSurvival);
}

}  // namespace photond
