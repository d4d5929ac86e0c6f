// Lee 1980: local statistics for noise filtering. Wiener 1949.
#include "core/film/reconstruct.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <vector>

#include "core/film/rows.h"

namespace photond {

namespace {

// Energies are estimated from few independent values: without this factor much noise would pass for signal. Between 1
// and 2 the relMSE of a Cornell box and of a lamp in a glass shell changed by 5 %; 2 is the quieter picture.
constexpr float kNoiseFactor = 2;
// Half the window of each band, in pixels: a little less than the radii of its kernels at the widest.
constexpr int kHalfWindow[kBands] = {5, 3, 2, 2};
// Epanechnikov kernels whose radii are one to two overlap: of the variance V of a band whose share is a, where the next
// coarser one's is b, the picture gets V·a·(a + b/3) [to 1 % of V; exact for shares that are all 0 or 1], and what is
// left out has V·a·(a + 5b/16) by the shares that are left out.
constexpr float kOverlap = 1.0f / 3;
constexpr float kOverlapLeft = 5.0f / 16;
// What all bands beyond one add up to, over that band: 1/3 for smooth fields (B r² − B (r/2)² = 3 B (r/2)²), 1.6 for
// the root mean square across a step. Stands for the bands finer than the last, where the geometric mean of the two is
// taken, and for those finer than one that is not added at all, where light is mostly smooth. So mean square errors are
// predicted a fifth too small where steps are all there is, a seventh too large under smooth light.
constexpr float kBeyondLast = 0.73f;
constexpr float kBeyondNone = 1.0f / 3;
// A share that depends on the very noise it multiplies errs by 4·V·(1 − a)/m more than a fixed one [Stein 1981], m the
// number of independent values in the window: between one, where kernels are much wider than the window, and many.
constexpr float kFollow = 4.0f / 2;
// Half the window of the bias: wider than those of the shares, whose errors would make it too small otherwise.
constexpr int kHalfBiasWindow = 8;

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

using Plane = ZeroedArray<float>;   // a number per pixel

// Means over a square window of the picture and its mirror images: those keep the mean over the picture. Sums of few
// summands: a prefix sum would leave the rounding of the brightest pixel everywhere.
void smooth(Plane& values, const Film& film, int half, const Execution& execution) {
  const auto width = static_cast<std::size_t>(film.width), height = static_cast<std::size_t>(film.height);
  const auto reach = static_cast<std::size_t>(half);
  const std::size_t side = 2 * reach + 1;
  const float scale = 1 / static_cast<float>(side);
  const std::vector<std::size_t> columns = mirrored(width, reach), lines = mirrored(height, reach);
  Plane rows(values.size());
  for_rows(film, execution, [&](std::size_t y) {
    std::vector<float> from(columns.size());
    for (std::size_t k = 0; k < from.size(); ++k) from[k] = values[y * width + columns[k]];
    float* const to = &rows[y * width];
    std::fill_n(to, width, 0.0f);
    for (std::size_t k = 0; k < side; ++k) {
      for (std::size_t x = 0; x < width; ++x) to[x] += scale * from[x + k];
    }
  });
  for_rows(film, execution, [&](std::size_t y) {
    float* const to = &values[y * width];
    std::fill_n(to, width, 0.0f);
    for (std::size_t k = y; k < y + side; ++k) {
      const float* const from = &rows[lines[k] * width];
      for (std::size_t x = 0; x < width; ++x) to[x] += scale * from[x];
    }
  });
}

// The bands of a film, means over its passes.
struct BandPicture {
  using Mean = std::array<Rgb, kBands>;

  ZeroedArray<Mean> mean;    // per pixel
  Plane energy[kBands];      // its square,
  Plane variance[kBands];    // and how much of that is noise

  BandPicture(const Film& film, const Execution& execution) : mean(film.bands.size()) {
    for (Plane& plane : energy) plane = Plane(mean.size());
    for (Plane& plane : variance) plane = Plane(mean.size());
    for_rows(film, execution, [&](std::size_t y) { set_row(film, y); });
  }

 private:
  void set_row(const Film& film, std::size_t y) {
    const auto width = static_cast<std::size_t>(film.width);
    const double per_pass = 1.0 / film.pass_count();
    std::array<double, 3 * kBands> value;
    std::array<double, kBands> noise;
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t i = y * width + x;
      values(film.bands[i].value[0].data(), value.data(), value.size());
      values(film.bands[i].variance.data(), noise.data(), noise.size());
      for (std::size_t band = 0; band < kBands; ++band) {
        const double* const v = &value[3 * band];
        const Rgb m(v[0] * per_pass, v[1] * per_pass, v[2] * per_pass);
        mean[i][band] = m;
        energy[band][i] = glm::dot(m, m);
        variance[band][i] = static_cast<float>(noise[band] * per_pass * per_pass);
      }
    }
  }
};

// Means over windows, of the pixels where photons were gathered: what lies beside those, as the sky does, has neither light
// nor error of theirs, and takes none from them.
class GatheredMeans {
 public:
  // By the energy of the coarsest band, which no photon of a finer one is without.
  GatheredMeans(const Film& film, const Plane& energy, const Execution& execution)
      : film_(film), execution_(execution), gathered_(energy.size()) {
    for (std::size_t i = 0; i < energy.size(); ++i) gathered_[i] = energy[i] > 0 ? 1.0f : 0.0f;
    everywhere_ = std::find(gathered_.begin(), gathered_.end(), 0.0f) == gathered_.end();
  }

  void take(std::initializer_list<Plane*> planes, int half) const {
    for (Plane* plane : planes) smooth(*plane, film_, half, execution_);
    if (everywhere_) return;
    Plane share(gathered_.size());
    std::copy(gathered_.begin(), gathered_.end(), share.begin());
    smooth(share, film_, half, execution_);
    for_pixels(film_, execution_, [&](std::size_t i) {
      const float scale = gathered_[i] > 0 ? 1 / share[i] : 0;
      for (Plane* plane : planes) (*plane)[i] *= scale;
    });
  }

 private:
  const Film& film_;
  const Execution& execution_;
  Plane gathered_;             // 1 where they were, else 0
  bool everywhere_ = false;
};

// What a pixel gets of its bands, from the coarsest on, and what it does not.
struct Mixture {
  float share = 1;   // of the last one
  Rgb mean{0};
  float variance = 0;
  Rgb left_out{0};
  float left_variance = 0;

  // A band's mean, and its energy and variance in the window.
  void add(int band, const Rgb& value, float energy, float noise) {
    const float coarser = share;
    const float wanted = energy > 0 ? std::max(0.0f, 1 - kNoiseFactor * noise / energy) : 0;
    share = std::min(coarser, wanted);
    mean += share * value;
    variance += share * (share + kOverlap * coarser) * noise;
    if (share > 0) variance += kFollow * (1 - share) * noise;
    const float beyond = share == 0 ? kBeyondNone : band == kBands - 1 ? kBeyondLast : 0;
    const float left = 1 - share + beyond;
    left_out += left * value;
    left_variance += left * (left + kOverlapLeft * (1 - coarser)) * noise;
  }
};

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
  for_rows(film, execution, [&](std::size_t y) {
    const auto width = static_cast<std::size_t>(film.width);
    pass_means(film, y * width, {&picture.mean[y * width].x, 3 * width});
  });
  if (film.bands.empty()) return picture;

  BandPicture bands(film, execution);
  const GatheredMeans means(film, bands.energy[0], execution);
  for (int band = 0; band < kBands; ++band) {
    means.take({&bands.energy[band], &bands.variance[band]}, kHalfWindow[band]);
  }
  Plane variance(pixels), left_energy(pixels), left_variance(pixels);
  for_pixels(film, execution, [&](std::size_t i) {
    Mixture mixture;   // finer bands than one without a share tell nothing but noise
    for (int band = 0; band < kBands && mixture.share > 0; ++band) {
      mixture.add(band, bands.mean[i][static_cast<std::size_t>(band)], bands.energy[band][i], bands.variance[band][i]);
    }
    picture.mean[i] += glm::dvec3(mixture.mean);
    variance[i] = mixture.variance;
    left_energy[i] = glm::dot(mixture.left_out, mixture.left_out);
    left_variance[i] = mixture.left_variance;
  });
  means.take({&left_energy, &left_variance}, kHalfBiasWindow);
  for_pixels(film, execution, [&](std::size_t i) {
    picture.variance[i] = by_channel(variance[i], picture.mean[i]);
    picture.bias_sq[i] = by_channel(left_energy[i] - left_variance[i], picture.mean[i]);
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
