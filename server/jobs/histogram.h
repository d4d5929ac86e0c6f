#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace photond {

/// Counts of durations by upper bounds, as Prometheus wants them.
template <std::size_t N>
struct Histogram {
  std::array<double, N> seconds_up_to;      ///< ascending
  std::array<std::uint64_t, N + 1> counts{};  ///< those within each bound and above the one before, then the rest
  double sum = 0;

  void add(double seconds) {
    const auto bound = std::lower_bound(seconds_up_to.begin(), seconds_up_to.end(), seconds);
    ++counts[static_cast<std::size_t>(bound - seconds_up_to.begin())];
    sum += seconds;
  }
};

}  // namespace photond
