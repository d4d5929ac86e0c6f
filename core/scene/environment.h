#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/digest.h"
#include "core/base/features.h"
#include "core/base/result.h"
#include "core/math/grid_distribution.h"
#include "core/math/types.h"

namespace photond {

/// A direction drawn from an environment.
struct EnvironmentSample {
  Vec3 wi{0};             ///< unit, towards the environment
  Rgb radiance{0};
  float pdf_w = 0;        ///< per solid angle; positive wherever the radiance is not black
};

/// An equirectangular picture of radiance from infinity, as seen from inside: +Y on top, +X in the middle, +Z to the
/// right of it. Between the centres of texels radiance is bilinear, beyond those next to a pole constant upwards.
/// Directions are drawn from what is constant between four centres, so that radiance over density is bounded.
class EnvironmentMap {
 public:
  /// `pixels`: width·height values, finite and not negative, the first row on top.
  EnvironmentMap(int width, int height, std::vector<Rgb> pixels);

  int width() const { return width_; }
  int height() const { return height_; }
  /// Of size and pixels.
  const Digest& digest() const { return digest_; }
  /// Mean over all directions and RGB.
  double mean() const { return mean_; }
  /// ∫L² over directions times 4π, over (∫L)²: 1 for a uniform sky, large where a sun dominates.
  double concentration() const { return concentration_; }
  std::uint64_t memory_bytes() const { return pixels_.size() * sizeof(Rgb) + distribution_.memory_bytes(); }

  Rgb radiance(const Vec3& direction) const;
  /// Not for a black map.
  EnvironmentSample sample(const Vec2& u) const;
  /// Density per solid angle of `sample`.
  float pdf(const Vec3& direction) const;

  std::vector<std::string> warnings;   ///< of what was wrong with the file

 private:
  // Cell x, y lies between the centres of columns x and x + 1 and of rows y − 1 and y; the first and the last row of
  // cells have half the height.
  struct Cell {
    std::uint32_t x, y;
    float s, t;           // linear in longitude and colatitude
  };
  Cell cell_at(const Vec3& direction) const;
  Rgb radiance(const Cell& cell) const;
  Rgb texel(std::uint32_t x, std::uint32_t row_of_cells) const;
  void make_distribution();

  int width_;
  int height_;
  std::vector<Rgb> pixels_;
  std::vector<double> cosines_;            // of the colatitude where rows of cells begin and end
  std::vector<float> inverse_angles_;      // of the cells of a row, 1/sr
  GridDistribution distribution_;          // over cells
  double mean_ = 0;
  double concentration_ = 1;
  Digest digest_;
};

struct EnvironmentLimits {
  int max_side = 16'384;
  std::uint64_t max_pixels = 1ull << 25;   ///< 8192 × 4096: about half a gigabyte
};

/// Reads an OpenEXR or Radiance HDR file. Limits are compared with the header before anything is decoded. Negative
/// values become zero, with a warning. Errors: unsupported (another format), limit_exceeded, invalid_input (corrupt,
/// or a value that is not finite).
Result<std::shared_ptr<const EnvironmentMap>> read_environment(std::span<const std::byte> bytes,
                                                               const EnvironmentLimits& limits = {});

/// Light from infinitely far away: a uniform radiance, or a map times it.
struct Environment {
  Rgb radiance{0};
  std::shared_ptr<const EnvironmentMap> map;   ///< null: uniform
  float rotation = 0;                          ///< radians about +Y: a quarter turn takes +X to −Z

  bool active() const { return kAllFeatures && !is_black(radiance) && (map == nullptr || map->mean() > 0); }
  /// Radiance that arrives from a unit direction.
  Rgb from(const Vec3& direction) const;
  /// Draws a direction in proportion to power. Not where the environment is not active.
  EnvironmentSample sample(const Vec2& u) const;
  /// Density per solid angle of `sample`.
  float pdf_w(const Vec3& direction) const;
  /// Radiance averaged over directions and RGB.
  double mean() const;
  /// EnvironmentMap::concentration, 1 without a map.
  double concentration() const { return map == nullptr ? 1 : map->concentration(); }
};

}  // namespace photond
