#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/result.h"
#include "core/base/zeroed_array.h"
#include "core/film/exact_sum.h"
#include "core/film/image.h"

namespace photond {

/// Passes [16b, 16b + 16) are block b. Within a block the camera samples may be stratified against one another;
/// blocks are independent, so only their means tell the variance.
inline constexpr std::uint32_t kBlockPasses = 16;

/// Passes first, …, last − 1.
struct PassRange {
  std::uint32_t first = 0;
  std::uint32_t last = 0;
  bool operator==(const PassRange&) const = default;
};

/// Sums over a set of passes. All are integers: the same passes give the same bits, however they were split into
/// films and in whatever order they were added.
struct Film {
  using Sums = ZeroedArray<std::array<ExactSum, 3>>;              ///< per pixel and channel
  using SquareSums = ZeroedArray<std::array<ExactSquareSum, 3>>;

  struct BandSums {
    std::array<std::array<ExactSum, 3>, kBands> value;
    std::array<ExactSquareSum, kBands> variance;
  };

  /// A block of which some passes are missing.
  struct OpenBlock {
    std::uint32_t index = 0;
    std::uint16_t passes = 0;  ///< bit i: pass 16·index + i is contained
    Sums sum;
  };

  int width = 0;
  int height = 0;
  std::vector<PassRange> passes;  ///< ascending, never touching
  std::uint64_t rejected = 0;     ///< pixels of passes that were not finite or too large, and count as black
  std::uint64_t truncated = 0;    ///< paths of passes that were cut at the depth limit
  std::uint32_t blocks = 0;       ///< complete ones
  Sums complete;                  ///< over the complete blocks
  SquareSums block_squares;       ///< of the complete blocks' means
  SquareSums pass_squares;        ///< of the passes; empty once there are kBlocksForEstimate complete blocks
  std::vector<OpenBlock> open;    ///< ascending by index
  ZeroedArray<float> largest;     ///< per pixel: largest R + G + B of a pass
  ZeroedArray<BandSums> bands;    ///< per pixel; empty where the passes have none

  Film() = default;
  Film(int w, int h);

  std::uint32_t pass_count() const;
  bool contains(std::uint32_t pass) const;
};

/// From this many complete blocks on their spread tells the variance, before that the spread of single passes.
inline constexpr std::uint32_t kBlocksForEstimate = 4;

/// Adds pass number `pass`, which must not be contained yet: pictures of the film's size. Is not interrupted by
/// the execution's stop token.
void add_pass(Film& film, std::uint32_t pass, const PassImage& image, const Execution& execution = {});

/// Adds all passes of `other`. Errors: another size; a pass that both contain.
Status merge_film(Film& film, const Film& other);

/// The mean of the passes' radiance, without their bands, channel by channel of the pixels from `first` on; black where
/// there are no passes.
void pass_means(const Film& film, std::size_t first, std::span<double> means);

/// Of one pixel.
glm::dvec3 pass_mean(const Film& film, std::size_t pixel);

}  // namespace photond
