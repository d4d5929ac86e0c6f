#include "core/film/film.h"

#include <cassert>
#include <cmath>

namespace photond {

void add_pass(Film& film, const Image& pass) {
  assert(pass.width == film.width && pass.height == film.height);
  for (std::size_t i = 0; i < film.sum.size(); ++i) {
    const glm::dvec3 value(pass.pixels[i]);
    film.sum[i] += value;
    film.sum_sq[i] += value * value;
  }
  ++film.passes;
  film.rejected += pass.rejected;
}

Image film_mean(const Film& film) {
  Image image(film.width, film.height);
  if (film.passes == 0) return image;
  const double scale = 1.0 / film.passes;
  for (std::size_t i = 0; i < film.sum.size(); ++i) image.pixels[i] = Rgb(film.sum[i] * scale);
  return image;
}

ErrorEstimate estimate_error(const Film& film) {
  if (film.passes < 2 || film.sum.empty()) return {};
  const double n = film.passes;
  double squares = 0, relative = 0;
  for (std::size_t i = 0; i < film.sum.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const double mean = film.sum[i][c] / n;
      // Var[mean] = Var[pass]/n, Var[pass] the unbiased (Σx² − n·mean²)/(n − 1); rounding may make it negative.
      const double variance = std::max(0.0, (film.sum_sq[i][c] - n * mean * mean) / (n - 1)) / n;
      squares += variance;
      relative += variance / (mean * mean + 0.01);
    }
  }
  const double count = 3.0 * static_cast<double>(film.sum.size());
  return {.rmse = std::sqrt(squares / count), .relative = std::sqrt(relative / count), .known = true};
}

}  // namespace photond
