#include "core/math/grid_distribution.h"

#include <algorithm>
#include <cassert>
#include <numeric>

namespace photond {

namespace {

// Random numbers are multiples of this: a share that is one, too, is met exactly, and one that is not positive never.
constexpr double kUnits = 0x1p24;

// The distribution function at the end of each item. Each of positive weight gets a unit, the rest is shared by weight.
template <class Weight>
void distribute(std::span<const Weight> weights, double sum, std::span<float> ends) {
  const auto lit = static_cast<double>(std::count_if(weights.begin(), weights.end(), [](Weight w) { return w > 0; }));
  double weight = 0, before = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    weight += static_cast<double>(weights[i]);
    before += weights[i] > 0;
    const double share = before == lit ? 1 : std::min(weight / sum, 1.0);
    ends[i] = static_cast<float>((before + std::floor((kUnits - lit) * share)) / kUnits);
  }
}

float start(std::span<const float> ends, std::size_t i) { return i == 0 ? 0 : ends[i - 1]; }

struct Item {
  std::uint32_t index;
  float within;
  float probability;
};

Item find(std::span<const float> ends, float u) {
  const auto found = std::upper_bound(ends.begin(), ends.end() - 1, u);
  const auto i = static_cast<std::uint32_t>(found - ends.begin());
  const float from = start(ends, i);
  const float width = ends[i] - from;
  return {i, std::clamp((u - from) / width, 0.0f, 1.0f), width};
}

}  // namespace

GridDistribution::GridDistribution(std::uint32_t columns, std::uint32_t rows, std::span<const float> weights)
    : columns_(columns), ends_of_rows_(rows), ends_(weights.size()) {
  assert(weights.size() == std::size_t{columns} * rows);
  std::vector<double> sums(rows);
  for (std::uint32_t y = 0; y < rows; ++y) {
    const auto cells = weights.subspan(std::size_t{y} * columns, columns);
    sums[y] = std::accumulate(cells.begin(), cells.end(), 0.0);
    if (sums[y] > 0) distribute(cells, sums[y], std::span(ends_).subspan(std::size_t{y} * columns, columns));
  }
  distribute(std::span<const double>(sums), std::accumulate(sums.begin(), sums.end(), 0.0), std::span(ends_of_rows_));
}

GridDistribution::Place GridDistribution::sample(const Vec2& u) const {
  const Item y = find(ends_of_rows_, u.y);
  const Item x = find(row(y.index), u.x);
  return {x.index, y.index, x.within, y.within, x.probability * y.probability};
}

float GridDistribution::probability(std::uint32_t x, std::uint32_t y) const {
  const auto cells = row(y);
  return (ends_of_rows_[y] - start(ends_of_rows_, y)) * (cells[x] - start(cells, x));
}

}  // namespace photond
