#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/math/scales.h"
#include "core/math/types.h"

namespace photond {

/// A picture of linear Rec. 709 radiance, first row on top.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<Rgb> pixels;        ///< width·height, row-major
  std::string note;               ///< what its files say of it: their description or comment; may be empty

  Image() = default;
  Image(int w, int h) : width(w), height(h), pixels(static_cast<std::size_t>(w) * h, Rgb(0)) {}

  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
  Rgb& at(int x, int y) { return pixels[index(x, y)]; }
  const Rgb& at(int x, int y) const { return pixels[index(x, y)]; }
};

/// What one pass gives.
struct PassImage {
  Image radiance;
  std::uint64_t truncated = 0;  ///< paths cut at the depth limit: the light of longer ones is missing
  std::vector<Bands> bands;  ///< per pixel: what narrower photon radii add to `radiance`; empty without photons
};

}  // namespace photond
