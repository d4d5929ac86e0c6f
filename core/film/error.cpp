// Hachisuka, Jarosz, Jensen: A Progressive Error Estimation Framework for Photon Density Estimation, 2010.
// Abramowitz, Stegun: Handbook of Mathematical Functions, 1964.
#include "core/film/error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/film/reconstruct.h"

namespace photond {
namespace {

/// Turns sums over passes into the variance of the mean.
class Variance {
 public:
  /// By blocks from `min_blocks` of them on.
  Variance(const Film& film, std::uint32_t min_blocks)
      : film_(film),
        by_blocks_(film.blocks >= min_blocks),
        count_(by_blocks_ ? film.blocks : film.pass_count()) {}

  double degrees() const { return count_ - 1; }

  /// Of pixel i and channel c; `pass_mean` is the mean over all passes.
  double operator()(std::size_t i, std::size_t c, double pass_mean) const {
    const double squares = (by_blocks_ ? film_.block_squares : film_.pass_squares)[i][c].value();
    const double mean = by_blocks_ ? film_.complete[i][c].value() / (count_ * kBlockPasses) : pass_mean;
    // Σ(x − mean)² = Σx² − n·mean²; what rounding leaves of equal values may be negative.
    return std::max(0.0, squares - count_ * mean * mean) / (count_ - 1) / count_;
  }

 private:
  const Film& film_;
  bool by_blocks_;
  double count_;
};

bool is_dominated(const Film& film, std::size_t pixel, const glm::dvec3& mean, std::uint32_t passes) {
  return film.largest[pixel] > 0.5 * passes * (mean.x + mean.y + mean.z);
}

}  // namespace

double t_quantile(double degrees) {
  if (degrees < 1.5) return std::tan(std::numbers::pi * 0.475);
  if (degrees < 2.5) return 0.95 * std::sqrt(2 / (1 - 0.95 * 0.95));
  // Cornish-Fisher expansion about the normal quantile [Abramowitz and Stegun 1964, 26.7.5].
  constexpr double z = 1.959963984540054, z2 = z * z;
  constexpr double g1 = z * (z2 + 1) / 4;
  constexpr double g2 = z * ((5 * z2 + 16) * z2 + 3) / 96;
  constexpr double g3 = z * (((3 * z2 + 19) * z2 + 17) * z2 - 15) / 384;
  constexpr double g4 = z * ((((79 * z2 + 776) * z2 + 1482) * z2 - 1920) * z2 - 945) / 92160;
  return z + (g1 + (g2 + (g3 + g4 / degrees) / degrees) / degrees) / degrees;
}

ErrorEstimate estimate_error(const Film& film, const Execution& execution) {
  const std::uint32_t passes = film.pass_count();
  if (passes < 2 || film.complete.empty()) return {};
  // A degree of freedom for each pixel is plenty for a mean over all.
  const Variance variance(film, 2);
  const Reconstruction picture = reconstruct(film, execution);
  double v_sum = 0, v_relative = 0, b_sum = 0, b_relative = 0;
  ErrorEstimate error{.known = true};
  for (std::size_t i = 0; i < film.complete.size(); ++i) {
    const glm::dvec3 mean = pass_mean(film, i);
    error.dominated += is_dominated(film, i, mean, passes);
    for (int c = 0; c < 3; ++c) {
      const double v = variance(i, static_cast<std::size_t>(c), mean[c]) + picture.variance[i][c];
      const double b_sq = picture.bias_sq[i][c];
      const double scale = 1 / (picture.mean[i][c] * picture.mean[i][c] + 0.01);
      v_sum += v, v_relative += v * scale;
      b_sum += b_sq, b_relative += b_sq * scale;
    }
  }
  const double count = 3.0 * static_cast<double>(film.complete.size());
  error.noise = std::sqrt(v_relative / count);
  error.bias = std::sqrt(std::max(0.0, b_relative) / count);
  error.relative = std::hypot(error.noise, error.bias);
  error.rmse = std::sqrt((v_sum + std::max(0.0, b_sum)) / count);
  return error;
}

ErrorLayers error_layers(const Film& film, const Execution& execution) {
  ErrorLayers layers{Image(film.width, film.height), Image(film.width, film.height), Image(film.width, film.height)};
  const std::uint32_t passes = film.pass_count();
  if (passes < 2) return layers;
  const Variance variance(film, kBlocksForEstimate);
  const double t = t_quantile(variance.degrees());
  const Reconstruction picture = reconstruct(film, execution);
  for (std::size_t i = 0; i < film.complete.size(); ++i) {
    const glm::dvec3 mean = pass_mean(film, i);
    for (int c = 0; c < 3; ++c) {
      const double v = variance(i, static_cast<std::size_t>(c), mean[c]) + picture.variance[i][c];
      const double noise = t * std::sqrt(v);
      const double bias = std::sqrt(std::max(0.0, picture.bias_sq[i][c]));
      layers.noise.pixels[i][c] = static_cast<float>(noise);
      layers.bias.pixels[i][c] = static_cast<float>(bias);
      layers.bound.pixels[i][c] = static_cast<float>(bias + noise);
    }
  }
  return layers;
}

std::vector<bool> dominated_pixels(const Film& film) {
  std::vector<bool> flags(film.complete.size());
  const std::uint32_t passes = film.pass_count();
  if (passes == 0) return flags;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    flags[i] = is_dominated(film, i, pass_mean(film, i), passes);
  }
  return flags;
}

}  // namespace photond
