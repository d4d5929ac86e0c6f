// Lee 1980: local statistics for noise filtering. Wiener 1949.
#include "core/film/reconstruct.h"

#include <algorithm>

namespace photond {

namespace {

// Energies are estimated from few independent values: without this factor much noise would pass for signal. Errors of
// the seven test scenes change by less than a tenth between 1.5 and 3.
constexpr double kNoiseFactor = 2;
// Half the window of each band, in pixels: a little less than the radii of its kernels at the widest.
constexpr int kHalfWindow[kBands] = {5, 3, 2, 2};
// Epanechnikov kernels whose radii are one to two overlap: of the variance V of a band whose share is a, where the next
// coarser one's is b, the picture gets V·a·(a + b/3) [to 1 % of V; exact for shares that are all 0 or 1], and what is
// left out has V·a·(a + 5b/16) by the shares that are left out.
constexpr double kOverlap = 1.0 / 3;
constexpr double kOverlapLeft = 5.0 / 16;
// What the finest estimate is off by, over what the last halving changed: 1/3 for smooth fields (B r² − B (r/2)² = 3 B
// (r/2)²), 1.6 for the root mean square across a step.
constexpr double kLastBias = 1;
// A share that depends on the very noise it multiplies errs by 4·V·(1 − a)/m more than a fixed one [Stein 1981], m the
// number of independent values in the window: between one, where kernels are much wider than the window, and many.
constexpr double kFollow = 4.0 / 2;
// Half the window of the bias: wider than those of the shares, whose errors would make it too small otherwise.
constexpr int kHalfBiasWindow = 8;

struct BandStatistics {
  double energy = 0;
  double variance = 0;
};

// Mean over the window of what lies inside the picture, along rows or columns of `step` and `length`.
void smooth_lines(std::vector<BandStatistics>& values, int lines, int line_step, int length, int step, int half) {
  std::vector<BandStatistics> prefix(static_cast<std::size_t>(length) + 1);
  for (int line = 0; line < lines; ++line) {
    BandStatistics* first = values.data() + static_cast<std::size_t>(line) * line_step;
    for (int k = 0; k < length; ++k) {
      const BandStatistics& v = first[static_cast<std::size_t>(k) * step];
      prefix[k + 1] = {prefix[k].energy + v.energy, prefix[k].variance + v.variance};
    }
    for (int k = 0; k < length; ++k) {
      const int begin = std::max(0, k - half), end = std::min(length, k + half + 1);
      const double scale = 1.0 / (end - begin);
      first[static_cast<std::size_t>(k) * step] = {(prefix[end].energy - prefix[begin].energy) * scale,
                                                   (prefix[end].variance - prefix[begin].variance) * scale};
    }
  }
}

glm::dvec3 band_mean(const Film::BandSums& sums, int band, double passes) {
  const auto& value = sums.value[band];
  return glm::dvec3(value[0].value(), value[1].value(), value[2].value()) / passes;
}

void smooth(std::vector<BandStatistics>& values, const Film& film, int half) {
  smooth_lines(values, film.height, film.width, film.width, 1, half);
  smooth_lines(values, film.width, 1, film.height, film.width, half);
}

// A scalar over RGB, dealt to the channels like the squares of the picture: photons have its colour.
glm::dvec3 by_channel(double value, const glm::dvec3& mean) {
  const double sum = glm::dot(mean, mean);
  return sum > 0 ? mean * mean * (value / sum) : glm::dvec3(value / 3);
}

}  // namespace

Reconstruction reconstruct(const Film& film) {
  const std::size_t pixels = film.complete.size();
  Reconstruction picture;
  picture.mean.resize(pixels);
  for (std::size_t i = 0; i < pixels; ++i) picture.mean[i] = pass_mean(film, i);
  picture.variance.assign(pixels, glm::dvec3(0));
  picture.bias_sq.assign(pixels, glm::dvec3(0));
  if (film.bands.empty()) return picture;

  const double passes = film.pass_count();
  std::vector<double> share(pixels, 1), variance(pixels, 0);
  std::vector<glm::dvec3> left_out(pixels, glm::dvec3(0));
  std::vector<BandStatistics> local(pixels), bias(pixels);
  for (int band = 0; band < kBands; ++band) {
    for (std::size_t i = 0; i < pixels; ++i) {
      const glm::dvec3 mean = band_mean(film.bands[i], band, passes);
      local[i] = {glm::dot(mean, mean), film.bands[i].variance[band].value() / (passes * passes)};
    }
    smooth(local, film, kHalfWindow[band]);
    for (std::size_t i = 0; i < pixels; ++i) {
      const BandStatistics& s = local[i];
      const double wanted = s.energy > 0 ? std::max(0.0, 1 - kNoiseFactor * s.variance / s.energy) : 0;
      const double coarser = share[i];
      share[i] = std::min(share[i], wanted);
      const glm::dvec3 mean = band_mean(film.bands[i], band, passes);
      picture.mean[i] += share[i] * mean;
      variance[i] += share[i] * (share[i] + kOverlap * coarser) * s.variance;
      if (share[i] > 0) variance[i] += kFollow * (1 - share[i]) * s.variance;
      const double left = band == kBands - 1 ? kLastBias : 1 - share[i];
      left_out[i] += left * mean;
      bias[i].variance += left * (left + kOverlapLeft * (1 - coarser)) * s.variance;
    }
  }
  for (std::size_t i = 0; i < pixels; ++i) bias[i].energy = glm::dot(left_out[i], left_out[i]);
  smooth(bias, film, kHalfBiasWindow);
  for (std::size_t i = 0; i < pixels; ++i) {
    picture.variance[i] = by_channel(variance[i], picture.mean[i]);
    picture.bias_sq[i] = by_channel(bias[i].energy - bias[i].variance, picture.mean[i]);
  }
  return picture;
}

Image film_picture(const Film& film) {
  Image image(film.width, film.height);
  const Reconstruction picture = reconstruct(film);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = Rgb(picture.mean[i]);
  return image;
}

}  // namespace photond
