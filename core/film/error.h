#pragma once

#include <cstdint>
#include <vector>

#include "core/film/film.h"

namespace photond {

/// How far a film's picture is from the true one: its noise from the spread of the passes and of the photons, its
/// bias from what the bands of narrower radii would change (reconstruct). What a method does not estimate is not
/// contained.
struct ErrorEstimate {
  double rmse = 0;            ///< √mean over pixels and channels of V + b², in radiance
  double relative = 0;        ///< √mean of (V + b²)/(m² + relative_floor), m the pixel's mean, but no more than that of the 24 around
                              ///< it where a few samples made it: comparable with √relMSE; √(noise² + bias²)
  double noise = 0;           ///< the part of V in `relative`
  double bias = 0;            ///< the part of b²
  std::uint64_t dominated = 0;///< pixels where a single pass holds over half of the sum: their V is not reliable
  bool known = false;         ///< false while there are fewer than two passes
};

/// V, the variance of the mean, is (spread of complete block means)/blocks: the passes of a block may depend on one
/// another, and the block that is not complete counts for the mean only. With fewer than two complete blocks
/// (kBlocksForEstimate for the error of single pixels) it is (spread of single passes)/passes, which is too large where
/// stratification within the blocks helps. The bands' share of V and the squared bias b² are Reconstruction's; b² is
/// clamped at 0 in the sum over the picture. Once the execution is cancelled the result means nothing.
ErrorEstimate estimate_error(const Film& film, const Execution& execution = {});

/// The error of each pixel and channel, in radiance.
struct ErrorLayers {
  Image noise;  ///< half width of the 95 % confidence interval: t·√V, t Student's quantile of V's degrees of freedom
  Image bias;   ///< b ≥ 0: root of the expected squared bias
  Image bound;  ///< what the error does not exceed with a probability of 95 %: error_bound
};
/// All black while there are fewer than two passes. Fewer than kReliablePasses passes say little about any pixel. Once
/// the execution is cancelled they mean nothing.
ErrorLayers error_layers(const Film& film, const Execution& execution = {});
inline constexpr std::uint32_t kReliablePasses = 8;

/// Pixels where a single pass holds more than half of the sum.
std::vector<bool> dominated_pixels(const Film& film);

/// The distance from the truth that an estimate with the given bias ≥ 0 and standard error, known with `degrees` ≥ 1
/// degrees of freedom, exceeds in 5 % of cases: t₉₇.₅·deviation where there is no bias, bias + t₉₅·deviation where it is
/// large, because only one side counts then. Covers 94.5 to 95.8 % of a normal estimate.
double error_bound(double bias, double deviation, double degrees);

/// The normal distribution's quantiles of 97.5 and 95 %.
inline constexpr double kZ975 = 1.959963984540054;
inline constexpr double kZ95 = 1.644853626951473;

/// The quantile of Student's t with `degrees` ≥ 1 degrees of freedom that belongs to the normal quantile `z`, for the
/// two above good to 0.2 %, between 1 and 3 degrees to 2 %.
double t_quantile(double degrees, double z = kZ975);

}  // namespace photond
