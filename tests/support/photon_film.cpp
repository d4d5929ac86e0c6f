#include "tests/support/photon_film.h"

#include <cmath>
#include <numbers>

namespace photond::test {

namespace {

// The number of points of a Poisson process in a unit of time, by its intervals.
int poisson(Rng& rng, double mean) {
  int count = 0;
  for (double time = -std::log(1.0 - static_cast<double>(rng.next())); time < mean; ++count) {
    time -= std::log(1.0 - static_cast<double>(rng.next()));
  }
  return count;
}

}  // namespace

PassImage PhotonPlane::pass(std::uint64_t seed, std::uint32_t number) const {
  PassImage image{.radiance = Image(side, side), .bands = std::vector<Bands>(static_cast<std::size_t>(side) * side)};
  Rng rng(seed, RngPurpose::photon, number, 0);
  const double per_area = photons / (std::numbers::pi * radius * radius);
  const double width = side + 2 * radius;
  const double value = 1 / per_area;
  const int count = poisson(rng, per_area * highest * width * width);
  for (int n = 0; n < count; ++n) {
    const Vec2 u = rng.next2();
    const double x = width * u.x - radius, y = width * u.y - radius;
    if (highest * rng.next() >= density(x, y)) continue;
    for (int py = std::max(0, static_cast<int>(y - radius)); py < std::min<double>(side, y + radius); ++py) {
      for (int px = std::max(0, static_cast<int>(x - radius)); px < std::min<double>(side, x + radius); ++px) {
        const double dx = px + 0.5 - x, dy = py + 0.5 - y;
        double wider = 0;
        for (int k = 0; k < kScales; ++k) {
          const double r_sq = radius * radius / std::exp2(2 * k);
          const double inside = 1 - (dx * dx + dy * dy) / r_sq;
          const double weight = inside > 0 ? value * 2 / (std::numbers::pi * r_sq) * inside : 0;
          if (k == 0) {
            image.radiance.at(px, py) += Rgb(static_cast<float>(weight));
          } else {
            Bands& bands = image.bands[image.radiance.index(px, py)];
            bands.value[k - 1] += Rgb(static_cast<float>(weight - wider));
            bands.variance[k - 1] += static_cast<float>(3 * (weight - wider) * (weight - wider));
          }
          if (weight == 0 && wider == 0) break;
          wider = weight;
        }
      }
    }
  }
  return image;
}

Film PhotonPlane::film(std::uint64_t seed, std::uint32_t count) const {
  Film film(side, side);
  for (std::uint32_t number = 0; number < count; ++number) add_pass(film, number, pass(seed, number));
  return film;
}

double PhotonPlane::truth(std::size_t pixel) const {
  const auto width = static_cast<std::size_t>(side);
  return density(static_cast<double>(pixel % width) + 0.5, static_cast<double>(pixel / width) + 0.5);
}

float normal(Rng& rng) {
  const float radius = std::sqrt(-2 * std::log(1 - rng.next()));
  return radius * std::cos(2 * kPi * rng.next());
}

double mean_square_error(const Image& picture, const PhotonPlane& plane) {
  double sum = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const double d = static_cast<double>(picture.pixels[i][c]) - plane.truth(i);
      sum += d * d;
    }
  }
  return sum / (3.0 * static_cast<double>(picture.pixels.size()));
}

}  // namespace photond::test
