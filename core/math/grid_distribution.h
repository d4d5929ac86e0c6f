#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math/types.h"

namespace photond {

/// Draws cells of a grid with given probabilities, rows first, and places within them. Monotone in both numbers, so
/// that stratified numbers give stratified places. Every cell of positive weight is drawn.
class GridDistribution {
 public:
  GridDistribution() = default;
  /// `weights`: row by row, finite and not negative, with a positive sum; at most 2²⁰ rows and columns.
  GridDistribution(std::uint32_t columns, std::uint32_t rows, std::span<const float> weights);

  struct Place {
    std::uint32_t x, y;        ///< the cell
    float s, t;                ///< where in it, in [0, 1]
    float probability;         ///< of the cell
  };
  /// For u in [0, 1)².
  Place sample(const Vec2& u) const;
  /// Probability of a cell.
  float probability(std::uint32_t x, std::uint32_t y) const;

  std::uint64_t memory_bytes() const { return (ends_of_rows_.size() + ends_.size()) * sizeof(float); }

 private:
  std::span<const float> row(std::uint32_t y) const { return {&ends_[std::size_t{y} * columns_], columns_}; }

  std::uint32_t columns_ = 0;
  std::vector<float> ends_of_rows_;  // distribution function at the end of each row
  std::vector<float> ends_;          // for each row, the distribution function at the end of each of its cells
};

}  // namespace photond
