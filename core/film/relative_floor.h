#pragma once

#include <algorithm>
#include <limits>

namespace photond {

/// What is added to the squared value that an error is related to, so that black pixels count: 0.1 squared, in a picture
/// whose mean is less than that the mean squared. Positive.
inline double relative_floor(double mean_of_picture) {
  const double level = std::min(0.1, mean_of_picture);
  return std::max(level * level, std::numeric_limits<double>::min());
}

}  // namespace photond
