#pragma once

#include <cstdint>
#include <vector>

#include "core/film/film.h"

namespace photond {

/// How far the mean of a film's passes is from the true picture: its noise from the spread of the passes, its bias
/// from their own estimates (PassImage::bias). What a method does not estimate is not contained.
struct ErrorEstimate {
  double rmse = 0;            ///< √mean over pixels and channels of V + b², in radiance
  double relative = 0;        ///< √mean of (V + b²)/(mean² + 0.01): comparable with √relMSE; √(noise² + bias²)
  double noise = 0;           ///< the part of V in `relative`
  double bias = 0;            ///< the part of b²
  std::uint64_t dominated = 0;///< pixels where a single pass holds over half of the sum: their V is not reliable
  bool known = false;         ///< false while there are fewer than two passes
};

/// V, the variance of the mean, is (spread of complete block means)/blocks: the passes of a block may depend on one
/// another, and the block that is not complete counts for the mean only. With fewer than kBlocksForEstimate
/// complete blocks it is (spread of single passes)/passes, which is too large where stratification within the
/// blocks helps. b², the squared bias, is the product of the bias means over even and over odd passes, each
/// smoothed over 5×5 pixels: their noise is independent, so that it cancels on average, where the square of one
/// mean would contain its variance. The sum over the picture is clamped at 0.
ErrorEstimate estimate_error(const Film& film);

/// The error of each pixel and channel, in radiance.
struct ErrorLayers {
  Image noise;  ///< half width of the 95 % confidence interval: t·√V, t Student's quantile of the estimate's degrees
  Image bias;   ///< b, signed: mean of the passes' estimates, smoothed over 5×5 pixels
  Image bound;  ///< |b| + noise
};
/// All black while there are fewer than two passes. Fewer than kReliablePasses passes say little about any pixel.
ErrorLayers error_layers(const Film& film);
inline constexpr std::uint32_t kReliablePasses = 8;

/// Pixels where a single pass holds more than half of the sum.
std::vector<bool> dominated_pixels(const Film& film);

/// The 97.5 % quantile of Student's t with `degrees` ≥ 1 degrees of freedom, good to 0.2 %.
double t_quantile(double degrees);

}  // namespace photond
