// Hachisuka, Jarosz, Jensen: A Progressive Error Estimation Framework for Photon Density Estimation, 2010.
// Abramowitz, Stegun: Handbook of Mathematical Functions, 1964. Welch: The Generalization of 'Student's' Problem when
// Several Different Population Variances are Involved, 1947.
#include "core/film/error.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/film/reconstruct.h"
#include "core/film/relative_floor.h"
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

  /// Channel by channel of the pixels from `first` on; `means` are those of all passes.
  void operator()(std::size_t first, std::span<const double> means, std::span<double> variances) const {
    values((by_blocks_ ? film_.block_squares : film_.pass_squares)[first].data(), variances.data(), variances.size());
    std::vector<double> sums;
    if (by_blocks_) {
      sums.resize(means.size());
      values(film_.complete[first].data(), sums.data(), sums.size());
    }
    const double* const x = by_blocks_ ? sums.data() : means.data();
    const double scale = by_blocks_ ? per_pass_ : 1;
    for (std::size_t k = 0; k < variances.size(); ++k) {
      const double mean = x[k] * scale;
      // Σ(x − mean)² = Σx² − n·mean²; what rounding leaves of equal values may be negative.
      variances[k] = std::max(0.0, variances[k] - count_ * mean * mean) * of_mean_;
    }
  }

 private:
  const Film& film_;
  bool by_blocks_;
  double count_;
  double per_pass_, of_mean_;   // what a sum over complete blocks and Σ(x − mean)² are multiplied by
};

// Row y of an array over the pixels, channel by channel.
std::span<const double> row_of(const ZeroedArray<glm::dvec3>& pixels, std::size_t width, std::size_t y) {
  static_assert(sizeof(glm::dvec3) == 3 * sizeof(double));
  return {&pixels[y * width].x, 3 * width};
}

// A row of the film, channel by channel: the means of the passes, and the variances of those by the spread of the passes.
struct FilmRow {
  std::vector<double> mean, variance;

  FilmRow(const Film& film, const Variance& variance_of, std::size_t y)
      : mean(3 * static_cast<std::size_t>(film.width)), variance(mean.size()) {
    const std::size_t first = y * static_cast<std::size_t>(film.width);
    pass_means(film, first, mean);
    variance_of(first, mean, variance);
  }
};

/// What an ErrorEstimate is made of, over some pixels.
struct ErrorSums {
  double v = 0, v_relative = 0;
  double b_sq = 0, b_sq_relative = 0;
  std::uint64_t dominated = 0;

  void add(const ErrorSums& other) {
    v += other.v, v_relative += other.v_relative;
    b_sq += other.b_sq, b_sq_relative += other.b_sq_relative;
    dominated += other.dominated;
  }
};

// Means of the 24 pixels around each; at the border, of those that there are, and of a single pixel its own.
class Surroundings {
 public:
  /// `mean(y, row)` puts row y, channel by channel, where it is to be.
  template <class Mean>
  Surroundings(const Film& film, const Execution& execution, const Mean& mean)
      : width_(static_cast<std::size_t>(film.width)), height_(static_cast<std::size_t>(film.height)),
        stride_(3 * (width_ + 2 * kReach)), means_(stride_ * (height_ + 2 * kReach)), columns_(3 * width_) {
    for (std::size_t k = 0; k < columns_.size(); ++k) columns_[k] = static_cast<double>(within(k / 3, width_));
    for_rows(film, execution, [&](std::size_t y) { mean(y, std::span(means_.data() + at(0, y), 3 * width_)); });
  }

  /// Of the picture.
  double mean() const {
    double sum = 0;
    for (std::size_t y = 0; y < height_; ++y) {
      const double* const row = &means_[at(0, y)];
      sum += std::accumulate(row, row + 3 * width_, 0.0);
    }
    return sum / static_cast<double>(3 * width_ * height_);
  }

  /// Of row y.
  std::vector<double> row(std::size_t y) const {
    std::vector<double> columns(stride_), around(columns_.size());
    for (std::size_t r = y; r <= y + 2 * kReach; ++r) {
      for (std::size_t k = 0; k < stride_; ++k) columns[k] += means_[r * stride_ + k];
    }
    const double* const own = &means_[at(0, y)];
    const auto rows = static_cast<double>(within(y, height_));
    for (std::size_t k = 0; k < around.size(); ++k) {
      double sum = -own[k];
      for (std::size_t step = 0; step <= 2 * kReach; ++step) sum += columns[k + 3 * step];
      const double others = rows * columns_[k] - 1;
      around[k] = others > 0 ? sum / others : own[k];
    }
    return around;
  }

 private:
  static constexpr std::size_t kReach = 2;   // pixels to all sides; black ones are all around the picture

  std::size_t at(std::size_t x, std::size_t y) const { return (y + kReach) * stride_ + 3 * (x + kReach); }
  // How many of 0 … n − 1 are not further than kReach from i.
  static std::size_t within(std::size_t i, std::size_t n) { return std::min(n, i + kReach + 1) - (i - std::min(i, kReach)); }

  std::size_t width_, height_, stride_;
  ZeroedArray<double> means_;
  std::vector<double> columns_;   // of each channel of a row, how many columns are not too far away
};

// What the error of a pixel is related to: its mean as far as it is known, else no more than what is around it. A pixel
// that one sample has made a thousand times too bright is a thousand times wrong, not by all that it shows; one that shows
// a lamp is as bright as it seems.
double level(double mean, double variance, double around) {
  constexpr double kFewSamples = 4;   // as many that share the mean tell nothing of it, many more all
  const double doubt = std::min(1.0, kFewSamples * variance / (mean * mean));
  return around < mean ? mean + doubt * (around - mean) : mean;
}

// Over numbers that belong together: means, their variances and squared biases, and the means of what is around them.
ErrorSums sum(std::span<const double> mean, std::span<const double> variance, std::span<const double> bias_sq,
              std::span<const double> around, double floor) {
  constexpr std::size_t kTogether = 8;
  double v[kTogether] = {}, v_relative[kTogether] = {}, b_sq[kTogether] = {}, b_sq_relative[kTogether] = {};
  const auto add = [&](std::size_t k, std::size_t j) {
    const double l = level(mean[k], variance[k], around[k]);
    const double scale = 1 / (l * l + floor);
    v[j] += variance[k], v_relative[j] += variance[k] * scale;
    b_sq[j] += bias_sq[k], b_sq_relative[j] += bias_sq[k] * scale;
  };
  const std::size_t whole = mean.size() / kTogether * kTogether;
  for (std::size_t k = 0; k < whole; k += kTogether) {
    for (std::size_t j = 0; j < kTogether; ++j) add(k + j, j);
  }
  for (std::size_t k = whole; k < mean.size(); ++k) add(k, k - whole);
  ErrorSums sums;
  for (std::size_t j = 0; j < kTogether; ++j) sums.add({v[j], v_relative[j], b_sq[j], b_sq_relative[j]});
  return sums;
}

bool is_dominated(const Film& film, std::size_t pixel, const double* mean, std::uint32_t passes) {
  return static_cast<double>(film.largest[pixel]) > 0.5 * passes * (mean[0] + mean[1] + mean[2]);
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
  const Surroundings surroundings(film, execution, [&](std::size_t y, std::span<double> means) {
    if (!banded) return pass_means(film, y * width, means);
    std::ranges::copy(row_of(picture.mean, width, y), means.begin());
  });
  const double floor = relative_floor(surroundings.mean());
  std::vector<ErrorSums> rows(static_cast<std::size_t>(film.height));
  for_rows(film, execution, [&](std::size_t y) {
    FilmRow row(film, variance, y);
    const std::vector<double> around = surroundings.row(y);
    if (banded) {
      const auto more = row_of(picture.variance, width, y);
      for (std::size_t k = 0; k < more.size(); ++k) row.variance[k] += more[k];
      rows[y] = sum(row_of(picture.mean, width, y), row.variance, row_of(picture.bias_sq, width, y), around, floor);
    } else {
      rows[y] = sum(row.mean, row.variance, std::vector<double>(row.mean.size()), around, floor);
    }
    for (std::size_t x = 0; x < width; ++x) {
      rows[y].dominated += is_dominated(film, y * width + x, &row.mean[3 * x], passes);
    }
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
  const auto width = static_cast<std::size_t>(film.width);
  for_rows(film, execution, [&](std::size_t y) {
    const FilmRow row(film, variance, y);
    const auto by_bands = row_of(picture.variance, width, y), bias_sq = row_of(picture.bias_sq, width, y);
    for (std::size_t k = 0; k < bias_sq.size(); ++k) {
      const double deviation = std::sqrt(row.variance[k] + by_bands[k]);
      const double degrees = variance.degrees(row.variance[k], by_bands[k]);
      const double bias = std::sqrt(std::max(0.0, bias_sq[k]));
      const std::size_t i = y * width + k / 3;
      const auto c = static_cast<int>(k % 3);
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
  const auto width = static_cast<std::size_t>(film.width);
  std::vector<double> means(3 * width);
  for (std::size_t first = 0; first < flags.size(); first += width) {
    pass_means(film, first, means);
    for (std::size_t x = 0; x < width; ++x) flags[first + x] = is_dominated(film, first + x, &means[3 * x], passes);
  }
  return flags;
}

}  // namespace photond
