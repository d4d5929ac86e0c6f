#pragma once

#include <glm/vec3.hpp>

#include "core/base/result.h"
#include "core/film/image.h"

namespace photond {

/// Differences of a picture `a` from a reference `r`, means over pixels and channels.
struct Comparison {
  double mse = 0;
  double rel_mse = 0;               ///< mean of (a − r)²/(r² + relative_floor)
  double rel_mse_trimmed = 0;       ///< the same without the worst 0.1 % of pixels
  glm::dvec3 mean_ratio{1};         ///< mean(a)/mean(r) per channel; 1 where both are 0
  double max_block_deviation = 0;   ///< largest |ā − r̄|/r̄ of 8×8-block means (luminance), over bright blocks
  double median_block_deviation = 0;///< median of the same; bright: r̄ above 1 % of the picture's mean
};

/// Errors where the sizes differ or a value is not finite.
Result<Comparison> compare_images(const Image& a, const Image& reference);

}  // namespace photond
