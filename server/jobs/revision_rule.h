#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace photond {

/// Says after which passes a picture is published: those nearest to powers of √2 (1, 2, 3, 4, 6, 8, 11, 16 …),
/// but not sooner than half a second and not later than ten seconds after the one before.
class RevisionRule {
 public:
  /// `now` in seconds on any steady clock, `passes` done so far; true at most once per pass.
  bool due(std::uint32_t passes, double now) {
    const double since = now - last_;
    const bool milestone = passes >= next_ && since >= kMinSeconds;
    if (!first_ && !milestone && since < kMaxSeconds) return false;
    first_ = false;
    last_ = now;
    while (next_ <= passes) next_ = following(next_);
    return true;
  }

 private:
  static constexpr double kMinSeconds = 0.5;  // a viewer's eye gains nothing from more
  static constexpr double kMaxSeconds = 10;

  static std::uint32_t following(std::uint32_t passes) {
    const double exponent = std::round(2 * std::log2(static_cast<double>(passes))) + 1;
    return std::max(passes + 1, static_cast<std::uint32_t>(std::lround(std::exp2(exponent / 2))));
  }

  bool first_ = true;
  double last_ = 0;
  std::uint32_t next_ = 1;
};

}  // namespace photond
