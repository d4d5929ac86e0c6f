// Lee 1980: local statistics for noise filtering. Wiener 1949.
#include "core/film/reconstruct.h"

#include <algorithm>
#include <vector>

#include "core/film/rows.h"

namespace photond {

namespace {

// Energies are estimated from few independent values: without this factor much noise would pass for signal. Between 1
// and 2 the relMSE of a Cornell box and of a lamp in a glass shell changed by 5 %; 2 is the quieter picture.
constexpr double kNoiseFactor = 2;
// Half the window of each band, in pixels: a little less than the radii of its kernels at the widest.
constexpr int kHalfWindow[kBands] = {5, 3, 2, 2};
// Epanechnikov kernels whose radii are one to two overlap: of the variance V of a band whose share is a, where the next
// coarser one's is b, the picture gets V·a·(a + b/3) [to 1 % of V; exact for shares that are all 0 or 1], and what is
// left out has V·a·(a + 5b/16) by the shares that are left out.
constexpr double kOverlap = 1.0 / 3;
constexpr double kOverlapLeft = 5.0 / 16;
// What all bands beyond one add up to, over that band: 1/3 for smooth fields (B r² − B (r/2)² = 3 B (r/2)²), 1.6 for
// the root mean square across a step. Stands for the bands finer than the last, where the geometric mean of the two is
// taken, and for those finer than one that is not added at all, where light is mostly smooth. So mean square errors are
// predicted a fifth too small where steps are all there is, a seventh too large under smooth light.
constexpr double kBeyondLast = 0.73;
constexpr double kBeyondNone = 1 / 3.0;
// A share that depends on the very noise it multiplies errs by 4·V·(1 − a)/m more than a fixed one [Stein 1981], m the
// number of independent values in the window: between one, where kernels are much wider than the window, and many.
constexpr double kFollow = 4.0 / 2;
// Half the window of the bias: wider than those of the shares, whose errors would make it too small otherwise.
constexpr int kHalfBiasWindow = 8;

struct BandStatistics {
  double energy = 0;
  double variance = 0;

  BandStatistics& operator+=(const BandStatistics& other) {
    energy += other.energy;
    variance += other.variance;
    return *this;
  }
  BandStatistics operator*(double factor) const { return {energy * factor, variance * factor}; }
};

// Numbers −reach, …, n − 1 + reach, those beyond an end mirrored at it.
std::vector<std::size_t> mirrored(std::size_t n, std::size_t reach) {
  std::vector<std::size_t> places(n + 2 * reach);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::size_t periods = reach / (2 * n) + 1;
    const std::size_t place = (i + 2 * n * periods - reach) % (2 * n);
    places[i] = std::min(place, 2 * n - 1 - place);
  }
  return places;
}

// Means over a square window of the picture and its mirror images: those keep the mean over the picture. Sums of few
// summands: a prefix sum would leave the rounding of the brightest pixel everywhere.
void smooth(ZeroedArray<BandStatistics>& values, const Film& film, int half, const Execution& execution) {
  const auto width = static_cast<std::size_t>(film.width), height = static_cast<std::size_t>(film.height);
  const auto reach = static_cast<std::size_t>(half);
  const std::size_t side = 2 * reach + 1;
  const double scale = 1 / static_cast<double>(side);
  const std::vector<std::size_t> columns = mirrored(width, reach), lines = mirrored(height, reach);
  ZeroedArray<BandStatistics> rows(values.size());
  for_rows(film, execution, [&](std::size_t y) {
    const BandStatistics* from = values.data() + y * width;
    for (std::size_t x = 0; x < width; ++x) {
      BandStatistics sum;
      for (std::size_t k = x; k < x + side; ++k) sum += from[columns[k]];
      rows[y * width + x] = sum * scale;
    }
  });
  for_rows(film, execution, [&](std::size_t y) {
    BandStatistics* to = values.data() + y * width;
    std::fill(to, to + width, BandStatistics{});
    for (std::size_t k = y; k < y + side; ++k) {
      const BandStatistics* from = rows.data() + lines[k] * width;
      for (std::size_t x = 0; x < width; ++x) to[x] += from[x] * scale;
    }
  });
}

glm::dvec3 band_mean(const Film::BandSums& sums, int band, double passes) {
  const auto& value = sums.value[band];
  return glm::dvec3(value[0].value(), value[1].value(), value[2].value()) / passes;
}

// A scalar over RGB, dealt to the channels like the squares of the picture: photons have its colour.
glm::dvec3 by_channel(double value, const glm::dvec3& mean) {
  const double sum = glm::dot(mean, mean);
  return sum > 0 ? mean * mean * (value / sum) : glm::dvec3(value / 3);
}

}  // namespace

Reconstruction reconstruct(const Film& film, const Execution& execution) {
  const std::size_t pixels = film.complete.size();
  Reconstruction picture{ZeroedArray<glm::dvec3>(pixels), ZeroedArray<glm::dvec3>(pixels),
                         ZeroedArray<glm::dvec3>(pixels)};
  for_pixels(film, execution, [&](std::size_t i) { picture.mean[i] = pass_mean(film, i); });
  if (film.bands.empty()) return picture;

  const double passes = film.pass_count();
  ZeroedArray<double> share(pixels), variance(pixels);
  ZeroedArray<glm::dvec3> mean(pixels), left_out(pixels);
  ZeroedArray<BandStatistics> local(pixels), bias(pixels);
  for (int band = 0; band < kBands; ++band) {
    for_pixels(film, execution, [&](std::size_t i) {
      mean[i] = band_mean(film.bands[i], band, passes);
      local[i] = {glm::dot(mean[i], mean[i]), film.bands[i].variance[band].value() / (passes * passes)};
    });
    smooth(local, film, kHalfWindow[band], execution);
    for_pixels(film, execution, [&](std::size_t i) {
      const double coarser = band == 0 ? 1 : share[i];
      if (coarser == 0) return;   // finer bands tell nothing but noise
      const BandStatistics& s = local[i];
      const double wanted = s.energy > 0 ? std::max(0.0, 1 - kNoiseFactor * s.variance / s.energy) : 0;
      share[i] = std::min(coarser, wanted);
      picture.mean[i] += share[i] * mean[i];
      variance[i] += share[i] * (share[i] + kOverlap * coarser) * s.variance;
      if (share[i] > 0) variance[i] += kFollow * (1 - share[i]) * s.variance;
      const double beyond = share[i] == 0 ? kBeyondNone : band == kBands - 1 ? kBeyondLast : 0;
      const double left = 1 - share[i] + beyond;
      left_out[i] += left * mean[i];
      bias[i].variance += left * (left + kOverlapLeft * (1 - coarser)) * s.variance;
    });
  }
  for_pixels(film, execution, [&](std::size_t i) { bias[i].energy = glm::dot(left_out[i], left_out[i]); });
  smooth(bias, film, kHalfBiasWindow, execution);
  for_pixels(film, execution, [&](std::size_t i) {
    picture.variance[i] = by_channel(variance[i], picture.mean[i]);
    picture.bias_sq[i] = by_channel(bias[i].energy - bias[i].variance, picture.mean[i]);
  });
  return picture;
}

Image film_picture(const Film& film, const Execution& execution) {
  Image image(film.width, film.height);
  const Reconstruction picture = reconstruct(film, execution);
  for_pixels(film, execution, [&](std::size_t i) { image.pixels[i] = Rgb(picture.mean[i]); });
  return image;
}

}  // namespace photond
