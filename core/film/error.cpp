// Hachisuka, Jarosz, Jensen: A Progressive Error Estimation Framework for Photon Density Estimation, 2010.
// Abramowitz, Stegun: Handbook of Mathematical Functions, 1964.
#include "core/film/error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace photond {
namespace {

constexpr int kSmoothRadius = 2;  // pixels: a window of 5×5

using Channels = std::vector<glm::dvec3>;

/// Turns sums over passes into the variance of the mean.
class Variance {
 public:
  explicit Variance(const Film& film)
      : film_(film),
        by_blocks_(film.blocks >= kBlocksForEstimate),
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

glm::dvec3 pass_mean(const Film& film, std::size_t pixel, std::uint32_t passes) {
  glm::dvec3 mean(0);
  for (std::size_t c = 0; c < 3; ++c) {
    ExactSum sum = film.complete[pixel][c];
    for (const Film::OpenBlock& block : film.open) sum.add(block.sum[pixel][c]);
    mean[static_cast<int>(c)] = sum.value() / passes;
  }
  return mean;
}

std::uint32_t count_parity(const Film& film, std::uint32_t parity) {
  std::uint32_t count = 0;
  for (const PassRange& range : film.passes) {
    count += (range.last + 1 - parity) / 2 - (range.first + 1 - parity) / 2;
  }
  return count;
}

/// Mean over the window around each pixel, of what lies inside the picture: along rows, then along columns.
Channels smooth(const Channels& in, int width, int height) {
  const auto along = [](const Channels& from, int lines, int length, int line_step, int step) {
    Channels to(from.size());
    for (int line = 0; line < lines; ++line) {
      const auto at = [&](int k) { return static_cast<std::size_t>(line) * line_step + static_cast<std::size_t>(k) * step; };
      for (int k = 0; k < length; ++k) {
        const int first = std::max(0, k - kSmoothRadius), last = std::min(length - 1, k + kSmoothRadius);
        glm::dvec3 sum(0);
        for (int j = first; j <= last; ++j) sum += from[at(j)];
        to[at(k)] = sum / static_cast<double>(last - first + 1);
      }
    }
    return to;
  };
  return along(along(in, height, width, width, 1), width, height, 1, width);
}

/// Means of the passes' bias estimates, smoothed; all empty where the film has none.
struct BiasMeans {
  Channels all;
  Channels even;
  Channels odd;  ///< even and odd: both `all` where one of them has no passes
};

Channels bias_mean(const Film::Sums& sums, std::uint32_t passes) {
  Channels mean(sums.size(), glm::dvec3(0));
  for (std::size_t i = 0; i < sums.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) mean[i][static_cast<int>(c)] = sums[i][c].value() / passes;
  }
  return mean;
}

BiasMeans bias_means(const Film& film) {
  BiasMeans means;
  if (film.bias[0].empty() && film.bias[1].empty()) return means;
  const double even = count_parity(film, 0), odd = count_parity(film, 1);
  const auto smoothed = [&](int parity, double count) {
    return smooth(bias_mean(film.bias[parity], static_cast<std::uint32_t>(count)), film.width, film.height);
  };
  if (even == 0 || odd == 0) {
    means.all = means.even = means.odd = smoothed(even == 0 ? 1 : 0, even + odd);
    return means;
  }
  means.even = smoothed(0, even);
  means.odd = smoothed(1, odd);
  means.all.resize(means.even.size());
  for (std::size_t i = 0; i < means.all.size(); ++i) {
    means.all[i] = (even * means.even[i] + odd * means.odd[i]) / (even + odd);
  }
  return means;
}

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

ErrorEstimate estimate_error(const Film& film) {
  const std::uint32_t passes = film.pass_count();
  if (passes < 2 || film.complete.empty()) return {};
  const Variance variance(film);
  const BiasMeans bias = bias_means(film);
  double v_sum = 0, v_relative = 0, b_sum = 0, b_relative = 0;
  ErrorEstimate error{.known = true};
  for (std::size_t i = 0; i < film.complete.size(); ++i) {
    const glm::dvec3 mean = pass_mean(film, i, passes);
    error.dominated += is_dominated(film, i, mean, passes);
    for (int c = 0; c < 3; ++c) {
      const double v = variance(i, static_cast<std::size_t>(c), mean[c]);
      const double b_sq = bias.all.empty() ? 0 : bias.even[i][c] * bias.odd[i][c];
      const double scale = 1 / (mean[c] * mean[c] + 0.01);
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

ErrorLayers error_layers(const Film& film) {
  ErrorLayers layers{Image(film.width, film.height), Image(film.width, film.height), Image(film.width, film.height)};
  const std::uint32_t passes = film.pass_count();
  if (passes < 2) return layers;
  const Variance variance(film);
  const double t = t_quantile(variance.degrees());
  const Channels bias = bias_means(film).all;
  for (std::size_t i = 0; i < film.complete.size(); ++i) {
    const glm::dvec3 mean = pass_mean(film, i, passes);
    for (int c = 0; c < 3; ++c) {
      const double noise = t * std::sqrt(variance(i, static_cast<std::size_t>(c), mean[c]));
      const double b = bias.empty() ? 0 : bias[i][c];
      layers.noise.pixels[i][c] = static_cast<float>(noise);
      layers.bias.pixels[i][c] = static_cast<float>(b);
      layers.bound.pixels[i][c] = static_cast<float>(std::abs(b) + noise);
    }
  }
  return layers;
}

std::vector<bool> dominated_pixels(const Film& film) {
  std::vector<bool> flags(film.complete.size());
  const std::uint32_t passes = film.pass_count();
  if (passes == 0) return flags;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    flags[i] = is_dominated(film, i, pass_mean(film, i, passes), passes);
  }
  return flags;
}

}  // namespace photond
