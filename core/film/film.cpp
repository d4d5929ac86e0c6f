#include "core/film/film.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <string>

#include "core/film/rows.h"

namespace photond {
namespace {

constexpr std::uint16_t kAllPasses = 0xffff;
static_assert(kBlockPasses == 16, "the passes of a block are the bits of a uint16_t");

// A film with half a pass would be lost.
Execution uninterrupted(const Execution& execution) { return {execution.arena, {}}; }

bool fits(const Rgb& value) {
  const auto in_range = [](float x) { return std::abs(x) < kLargestSummand; };  // false for NaN
  return in_range(value.x) && in_range(value.y) && in_range(value.z);
}

void add_ranges(std::vector<PassRange>& ranges, const std::vector<PassRange>& more) {
  ranges.insert(ranges.end(), more.begin(), more.end());
  std::sort(ranges.begin(), ranges.end(), [](PassRange a, PassRange b) { return a.first < b.first; });
  std::vector<PassRange> joined;
  for (const PassRange& range : ranges) {
    if (!joined.empty() && joined.back().last == range.first) {
      joined.back().last = range.last;
    } else {
      joined.push_back(range);
    }
  }
  ranges = std::move(joined);
}

Film::OpenBlock& open_block(Film& film, std::uint32_t index) {
  const auto at = std::lower_bound(film.open.begin(), film.open.end(), index,
                                   [](const Film::OpenBlock& block, std::uint32_t i) { return block.index < i; });
  if (at != film.open.end() && at->index == index) return *at;
  return *film.open.insert(at, {index, 0, Film::Sums(film.complete.size())});
}

/// Moves the block into the sums of the complete ones where no pass is missing any more.
void close_if_complete(Film& film, std::uint32_t index, const Execution& execution) {
  Film::OpenBlock& block = open_block(film, index);
  if (block.passes != kAllPasses) return;
  if (film.block_squares.empty()) film.block_squares = Film::SquareSums(film.complete.size());
  for_pixels(film, uninterrupted(execution), [&](std::size_t i) {
    for (std::size_t c = 0; c < 3; ++c) {
      film.complete[i][c].add(block.sum[i][c]);
      film.block_squares[i][c].add_square(block.sum[i][c].value() / kBlockPasses);
    }
  });
  film.open.erase(film.open.begin() + (&block - film.open.data()));
  if (++film.blocks >= kBlocksForEstimate) film.pass_squares = {};
}

bool fits(const Bands& bands) {
  for (int j = 0; j < kBands; ++j) {
    if (!fits(bands.value[j]) || std::isnan(bands.variance[j])) return false;
  }
  return true;
}

void add(std::array<ExactSum, 3>* sums, std::span<const Rgb> values) {
  static_assert(sizeof *sums == 3 * sizeof(ExactSum) && sizeof(Rgb) == 3 * sizeof(float));
  add(reinterpret_cast<ExactSum*>(sums), reinterpret_cast<const float*>(values.data()), 3 * values.size());
}

// The root of a variance. Noise beyond what fits is told too small: there is light all the same.
float deviation(float variance) {
  constexpr float kMost = kLargestSummand * (1 - 0x1p-24f);
  return std::min(std::sqrt(variance), kMost);
}

// Variances are sums of squares: otherwise those of light a billion times as bright or dim would leave the range.
void add(Film::BandSums* sums, std::span<const Bands> bands) {
  for (std::size_t i = 0; i < bands.size(); ++i) {
    std::array<float, kBands> deviations;
    std::ranges::transform(bands[i].variance, deviations.begin(), deviation);
    add(sums[i].value[0].data(), &bands[i].value[0].x, 3 * kBands);
    add_squares(sums[i].variance.data(), deviations.data(), kBands);
  }
}

// Adds row y of a pass, black where its values do not fit. Returns how many do not.
std::uint64_t add_row(Film& film, Film::Sums& sum, const PassImage& image, std::size_t y) {
  const auto width = static_cast<std::size_t>(film.width);
  const std::size_t first = y * width;
  const Rgb* row = &image.radiance.pixels[first];
  std::vector<Rgb> radiance(row, row + width);
  std::vector<Bands> bands;
  if (!image.bands.empty()) bands.assign(&image.bands[first], &image.bands[first] + width);
  std::uint64_t rejected = 0;
  for (std::size_t i = 0; i < width; ++i) {
    const bool fine = fits(radiance[i]) && (bands.empty() || fits(bands[i]));
    if (fine) continue;
    radiance[i] = Rgb(0);
    if (!bands.empty()) bands[i] = {};
    ++rejected;
  }
  add(&sum[first], radiance);
  if (!bands.empty()) add(&film.bands[first], bands);
  if (!film.pass_squares.empty()) add_squares(film.pass_squares[first].data(), &radiance[0].x, 3 * width);
  for (std::size_t i = 0; i < width; ++i) {
    const Rgb& value = radiance[i];
    film.largest[first + i] = std::max(film.largest[first + i], value.x + value.y + value.z);
  }
  return rejected;
}

void merge_bands(ZeroedArray<Film::BandSums>& to, const ZeroedArray<Film::BandSums>& from) {
  if (from.empty()) return;
  if (to.empty()) to = ZeroedArray<Film::BandSums>(from.size());
  for (std::size_t i = 0; i < to.size(); ++i) {
    for (int j = 0; j < kBands; ++j) {
      for (int c = 0; c < 3; ++c) to[i].value[j][c].add(from[i].value[j][c]);
      to[i].variance[j].add(from[i].variance[j]);
    }
  }
}

template <class Sums>
void add_sums(Sums& to, const Sums& from) {
  if (from.empty()) return;
  if (to.empty()) to = Sums(from.size());
  for (std::size_t i = 0; i < to.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) to[i][c].add(from[i][c]);
  }
}

}  // namespace

Film::Film(int w, int h) : width(w), height(h) {
  const std::size_t pixels = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
  complete = Sums(pixels);
  pass_squares = SquareSums(pixels);
  largest = ZeroedArray<float>(pixels);
}

std::uint32_t Film::pass_count() const {
  std::uint32_t count = 0;
  for (const PassRange& range : passes) count += range.last - range.first;
  return count;
}

bool Film::contains(std::uint32_t pass) const {
  const auto after = std::upper_bound(passes.begin(), passes.end(), pass,
                                      [](std::uint32_t p, PassRange range) { return p < range.first; });
  return after != passes.begin() && pass < std::prev(after)->last;
}

void add_pass(Film& film, std::uint32_t pass, const PassImage& image, const Execution& execution) {
  const std::size_t pixels = film.complete.size();
  assert(image.radiance.pixels.size() == pixels && !film.contains(pass));
  if (!image.bands.empty() && film.bands.empty()) film.bands = ZeroedArray<Film::BandSums>(pixels);
  Film::OpenBlock& block = open_block(film, pass / kBlockPasses);
  std::atomic<std::uint64_t> rejected = 0;
  for_rows(film, uninterrupted(execution), [&](std::size_t y) { rejected += add_row(film, block.sum, image, y); });
  film.rejected += rejected;
  film.truncated += image.truncated;
  block.passes = static_cast<std::uint16_t>(block.passes | 1u << (pass % kBlockPasses));
  add_ranges(film.passes, {{pass, pass + 1}});
  close_if_complete(film, pass / kBlockPasses, execution);
}

Status merge_film(Film& film, const Film& other) {
  if (film.width != other.width || film.height != other.height) {
    return invalid_input("the films have different sizes");
  }
  for (const PassRange& a : film.passes) {
    for (const PassRange& b : other.passes) {
      const std::uint32_t first = std::max(a.first, b.first), last = std::min(a.last, b.last);
      if (first < last) {
        return invalid_input("both contain the passes " + std::to_string(first) + ":" + std::to_string(last));
      }
    }
  }
  film.rejected += other.rejected;
  film.truncated += other.truncated;
  add_sums(film.complete, other.complete);
  add_sums(film.block_squares, other.block_squares);
  merge_bands(film.bands, other.bands);
  for (std::size_t i = 0; i < film.largest.size(); ++i) {
    film.largest[i] = std::max(film.largest[i], other.largest[i]);
  }
  film.blocks += other.blocks;
  if (film.blocks >= kBlocksForEstimate) {
    film.pass_squares = {};
  } else {
    add_sums(film.pass_squares, other.pass_squares);
  }
  add_ranges(film.passes, other.passes);
  for (const Film::OpenBlock& more : other.open) {
    Film::OpenBlock& block = open_block(film, more.index);
    block.passes |= more.passes;
    add_sums(block.sum, more.sum);
    close_if_complete(film, more.index, {});
  }
  return Done{};
}

void pass_means(const Film& film, std::size_t first, std::span<double> means) {
  const std::uint32_t passes = film.pass_count();
  const ExactSum* const complete = film.complete[first].data();
  std::vector<ExactSum> sums(complete, complete + means.size());
  for (const Film::OpenBlock& block : film.open) {
    const ExactSum* const more = block.sum[first].data();
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k].add(more[k]);
  }
  values(sums.data(), means.data(), means.size());
  for (double& mean : means) mean = passes > 0 ? mean / passes : 0;
}

glm::dvec3 pass_mean(const Film& film, std::size_t pixel) {
  std::array<double, 3> mean;
  pass_means(film, pixel, mean);
  return {mean[0], mean[1], mean[2]};
}

}  // namespace photond
