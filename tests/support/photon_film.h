#pragma once

#include <functional>

#include "core/film/film.h"
#include "core/math/rng.h"

namespace photond::test {

/// A plane under photons of a known density, seen from above: each pixel's radiance is the density at its center.
struct PhotonPlane {
  int side = 48;                                  ///< pixels
  double radius = 24;                             ///< of the widest kernel, in pixels
  double photons = 150;                           ///< within that radius at density 1, in one pass
  std::function<double(double x, double y)> density = [](double, double) { return 1.0; };  ///< in pixels; ≥ 0
  double highest = 1;                             ///< density never exceeds it

  /// The estimates at all scales by photons of one pass, white, and the bands' variances, as a photon gather gives
  /// them. There are photons beyond the picture's border too.
  PassImage pass(std::uint64_t seed, std::uint32_t number) const;
  /// The film of the passes 0, …, count − 1.
  Film film(std::uint64_t seed, std::uint32_t count) const;
  double truth(std::size_t pixel) const;
};

/// Normally distributed by Box and Muller, mean 0, variance 1.
float normal(Rng& rng);

/// Mean over pixels and channels of (picture − truth)².
double mean_square_error(const Image& picture, const PhotonPlane& plane);

}  // namespace photond::test
