#pragma once

#include <cmath>
#include <optional>
#include <span>

namespace photond::bench {

/// A positive quantity at a positive time.
struct TimePoint {
  double seconds;
  double value;
};

/// The exponent p of c·tᵖ by least squares of the logarithms; nothing where all points share a time.
inline std::optional<double> fitted_exponent(std::span<const TimePoint> points) {
  const auto n = static_cast<double>(points.size());
  double x = 0, y = 0;
  for (const TimePoint& p : points) x += std::log(p.seconds) / n, y += std::log(p.value) / n;
  double xx = 0, xy = 0;
  for (const TimePoint& p : points) {
    const double dx = std::log(p.seconds) - x;
    xx += dx * dx;
    xy += dx * (std::log(p.value) - y);
  }
  if (!(xx > 0)) return std::nullopt;
  return xy / xx;
}

}  // namespace photond::bench
