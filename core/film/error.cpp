// Hachisuka, Jarosz, Jensen: A Progressive Error Estimation Framework for Photon Density Estimation, 2010.
// Abramowitz, Stegun: Handbook of Mathematical Functions, 1964. Welch: The Generalization of 'Student's' Problem when
// Several Different Population Variances are Involved, 1947.
#include "core/film/error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/film/reconstruct.h"
#include "core/film/rows.h"

namespace photond {
namespace {

/// Turns sums over passes into the variance of the mean.
class Variance {
 public:
  /// By blocks from `min_blocks` of them on.
  Variance(const Film& film, std::uint32_t min_blocks)
      : film_(film),
        by_blocks_(film.blocks >= min_blocks),
        count_(by_blocks_ ? film.blocks : film.pass_count()),
        per_pass_(1 / (count_ * kBlockPasses)),
        of_mean_(1 / (count_ - 1) / count_) {}

  /// Of the sum of a variance of these passes and of another one that is known well, as that of many photons
  /// [Welch 1947].
  double degrees(double own, double other) const {
    const double ratio = own > 0 ? (own + other) / own : 1;
    return (count_ - 1) * ratio * ratio;
  }

  /// Of pixel i and channel c; `pass_mean` is the mean over all passes.
  double operator()(std::size_t i, std::size_t c, double pass_mean) const {
    const double squares = (by_blocks_ ? film_.block_squares : film_.pass_squares)[i][c].value();
    const double mean = by_blocks_ ? film_.complete[i][c].value() * per_pass_ : pass_mean;
    // Σ(x − mean)² = Σx² − n·mean²; what rounding leaves of equal values may be negative.
    return std::max(0.0, squares - count_ * mean * mean) * of_mean_;
  }

 private:
  const Film& film_;
  bool by_blocks_;
  double count_;
  double per_pass_, of_mean_;   // what a sum over complete blocks and Σ(x − mean)² are multiplied by
};

/// What an ErrorEstimate is made of, over some pixels.
struct ErrorSums {
  double v = 0, v_relative = 0;
  double b_sq = 0, b_sq_relative = 0;
  std::uint64_t dominated = 0;

  void add(double variance, double bias_sq, double level) {
    const double scale = 1 / (level * level + 0.01);
    v += variance, v_relative += variance * scale;
    b_sq += bias_sq, b_sq_relative += bias_sq * scale;
  }
  void add(const ErrorSums& other) {
    v += other.v, v_relative += other.v_relative;
    b_sq += other.b_sq, b_sq_relative += other.b_sq_relative;
    dominated += other.dominated;
  }
};

// Means of the 24 pixels around each; at the border, of those that there are, and of a single pixel its own.
class Surroundings {
 public:
  /// `mean(i)`: of pixel i.
  template <class Mean>
  Surroundings(const Film& film, const Execution& execution, const Mean& mean)
      : width_(static_cast<std::size_t>(film.width)), height_(static_cast<std::size_t>(film.height)),
        stride_(3 * (width_ + 2 * kReach)), means_(stride_ * (height_ + 2 * kReach), 0.0f) {
    for_rows(film, execution, [&](std::size_t y) {
      for (std::size_t x = 0; x < width_; ++x) {
        const glm::dvec3 m = mean(y * width_ + x);
        for (int c = 0; c < 3; ++c) means_[at(x, y) + static_cast<std::size_t>(c)] = static_cast<float>(m[c]);
      }
    });
  }

  /// Of row y, channel by channel.
  std::vector<float> row(std::size_t y) const {
    std::vector<double> columns(stride_, 0.0);
    std::vector<float> around(3 * width_);
    for (std::size_t r = y; r <= y + 2 * kReach; ++r) {
      for (std::size_t k = 0; k < stride_; ++k) columns[k] += static_cast<double>(means_[r * stride_ + k]);
    }
    const float* const own = &means_[at(0, y)];
    const std::size_t rows = within(y, height_);
    for (std::size_t k = 0; k < around.size(); ++k) {
      double sum = -static_cast<double>(own[k]);
      for (std::size_t step = 0; step <= 2 * kReach; ++step) sum += columns[k + 3 * step];
      const std::size_t others = rows * within(k / 3, width_) - 1;
      around[k] = others > 0 ? static_cast<float>(sum / static_cast<double>(others)) : own[k];
    }
    return around;
  }

 private:
  static constexpr std::size_t kReach = 2;   // pixels to all sides; black ones are all around the picture

  std::size_t at(std::size_t x, std::size_t y) const { return (y + kReach) * stride_ + 3 * (x + kReach); }
  // How many of 0 … n − 1 are not further than kReach from i.
  static std::size_t within(std::size_t i, std::size_t n) { return std::min(n, i + kReach + 1) - (i - std::min(i, kReach)); }

  std::size_t width_, height_, stride_;
  std::vector<float> means_;
};

// What the error of a pixel is related to: its mean as far as it is known, else no more than what is around it. A pixel
// that one sample has made a thousand times too bright is a thousand times wrong, not by all that it shows; one that shows
// a lamp is as bright as it seems.
double level(double mean, double variance, double around) {
  if (!(around < mean)) return mean;
  constexpr double kFewSamples = 4;   // as many that share the mean tell nothing of it, many more all
  const double doubt = std::min(1.0, kFewSamples * variance / (mean * mean));
  return mean + doubt * (around - mean);
}

bool is_dominated(const Film& film, std::size_t pixel, const glm::dvec3& mean, std::uint32_t passes) {
  return film.largest[pixel] > 0.5 * passes * (mean.x + mean.y + mean.z);
}

}  // namespace

double t_quantile(double degrees, double z) {
  if (degrees < 3 && degrees != std::floor(degrees)) {
    const double below = std::floor(degrees), above = below + 1;
    const auto place = [](double d) { return 1 / (d * std::sqrt(d)); };   // the logarithm is nearly linear in this
    const double share = (place(degrees) - place(above)) / (place(below) - place(above));
    return std::pow(t_quantile(below, z), share) * std::pow(t_quantile(above, z), 1 - share);
  }
  const double p = 0.5 * std::erfc(-z / std::numbers::sqrt2);
  if (degrees == 1) return std::tan(std::numbers::pi * (p - 0.5));
  if (degrees == 2) return (2 * p - 1) / std::sqrt(2 * p * (1 - p));
  // Cornish-Fisher expansion about the normal quantile [Abramowitz and Stegun 1964, 26.7.5].
  const double z2 = z * z;
  const double g1 = z * (z2 + 1) / 4;
  const double g2 = z * ((5 * z2 + 16) * z2 + 3) / 96;
  const double g3 = z * (((3 * z2 + 19) * z2 + 17) * z2 - 15) / 384;
  const double g4 = z * ((((79 * z2 + 776) * z2 + 1482) * z2 - 1920) * z2 - 945) / 92160;
  return z + (g1 + (g2 + (g3 + g4 / degrees) / degrees) / degrees) / degrees;
}

double error_bound(double bias, double deviation, double degrees) {
  if (!(deviation > 0)) return bias;
  const double two_sided = t_quantile(degrees), one_sided = t_quantile(degrees, kZ95);
  // From one to the other with the slope 0 that symmetry demands where there is no bias.
  const double other_side = std::exp(-bias / (deviation * (two_sided - one_sided)));
  return bias + deviation * (one_sided + (two_sided - one_sided) * other_side);
}

ErrorEstimate estimate_error(const Film& film, const Execution& execution) {
  const std::uint32_t passes = film.pass_count();
  if (passes < 2 || film.complete.empty()) return {};
  // A degree of freedom for each pixel is plenty for a mean over all.
  const Variance variance(film, 2);
  const bool banded = !film.bands.empty();   // otherwise the picture is the mean, and nothing is left out
  const Reconstruction picture = banded ? reconstruct(film, execution) : Reconstruction{};
  const auto width = static_cast<std::size_t>(film.width);
  const Surroundings surroundings(film, execution, [&](std::size_t i) { return banded ? picture.mean[i] : pass_mean(film, i); });
  std::vector<ErrorSums> rows(static_cast<std::size_t>(film.height));
  for_rows(film, execution, [&](std::size_t y) {
    ErrorSums row;
    const std::vector<float> near = surroundings.row(y);
    for (std::size_t i = y * width; i < (y + 1) * width; ++i) {
      const glm::dvec3 mean = pass_mean(film, i);
      row.dominated += is_dominated(film, i, mean, passes);
      for (int c = 0; c < 3; ++c) {
        const double v = variance(i, static_cast<std::size_t>(c), mean[c]);
        const auto around = static_cast<double>(near[3 * (i - y * width) + static_cast<std::size_t>(c)]);
        if (banded) {
          const double all = v + picture.variance[i][c];
          row.add(all, picture.bias_sq[i][c], level(picture.mean[i][c], all, around));
        } else {
          row.add(v, 0, level(mean[c], v, around));
        }
      }
    }
    rows[y] = row;
  });
  ErrorSums sums;
  for (const ErrorSums& row : rows) sums.add(row);
  const double count = 3.0 * static_cast<double>(film.complete.size());
  ErrorEstimate error{.dominated = sums.dominated, .known = true};
  error.noise = std::sqrt(sums.v_relative / count);
  error.bias = std::sqrt(std::max(0.0, sums.b_sq_relative) / count);
  error.relative = std::hypot(error.noise, error.bias);
  error.rmse = std::sqrt((sums.v + std::max(0.0, sums.b_sq)) / count);
  return error;
}

ErrorLayers error_layers(const Film& film, const Execution& execution) {
  ErrorLayers layers{Image(film.width, film.height), Image(film.width, film.height), Image(film.width, film.height)};
  const std::uint32_t passes = film.pass_count();
  if (passes < 2) return layers;
  const Variance variance(film, kBlocksForEstimate);
  const Reconstruction picture = reconstruct(film, execution);
  for_pixels(film, execution, [&](std::size_t i) {
    const glm::dvec3 mean = pass_mean(film, i);
    for (int c = 0; c < 3; ++c) {
      const double own = variance(i, static_cast<std::size_t>(c), mean[c]);
      const double deviation = std::sqrt(own + picture.variance[i][c]);
      const double degrees = variance.degrees(own, picture.variance[i][c]);
      const double bias = std::sqrt(std::max(0.0, picture.bias_sq[i][c]));
      layers.noise.pixels[i][c] = static_cast<float>(t_quantile(degrees) * deviation);
      layers.bias.pixels[i][c] = static_cast<float>(bias);
      layers.bound.pixels[i][c] = static_cast<float>(error_bound(bias, deviation, degrees));
    }
  });
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
