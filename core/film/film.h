#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "core/film/image.h"

namespace photond {

/// Sums over passes of each pixel's radiance and of its square, in double precision. Passes are added in
/// ascending order, so equal passes give equal bits.
struct Film {
  int width = 0;
  int height = 0;
  std::uint32_t passes = 0;
  std::uint64_t rejected = 0;     ///< samples of all passes that were not finite
  std::vector<glm::dvec3> sum;
  std::vector<glm::dvec3> sum_sq;

  Film() = default;
  Film(int w, int h)
      : width(w), height(h), sum(static_cast<std::size_t>(w) * h), sum_sq(static_cast<std::size_t>(w) * h) {}
};

/// Adds one pass: a picture of the film's size.
void add_pass(Film& film, const Image& pass);

/// The mean over the passes; black where there are none.
Image film_mean(const Film& film);

/// How far the mean is from the expected value, from the spread of the passes.
struct ErrorEstimate {
  double rmse = 0;            ///< √mean over pixels and channels of Var[mean], in radiance
  double relative = 0;        ///< √mean of Var[mean]/(mean² + 0.01): comparable with √relMSE
  bool known = false;         ///< false while there are fewer than two passes
};
/// Noise only: a bias of the method is not contained.
ErrorEstimate estimate_error(const Film& film);

}  // namespace photond
