#include "core/math/alias_table.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <numeric>

namespace photond {

AliasTable::AliasTable(std::span<const double> weights) : bins_(std::bit_ceil(weights.size())) {
  assert(weights.size() <= kMostWeights);
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  const auto n = static_cast<double>(bins_.size());
  const double steps = static_cast<double>(kMostWeights) / n;   // of u in a bin
  const auto heaviest = static_cast<std::uint32_t>(std::ranges::max_element(weights) - weights.begin());
  std::vector<double> scaled(bins_.size());
  std::vector<std::uint32_t> small;
  std::vector<std::uint32_t> large;
  for (std::uint32_t i = 0; i < bins_.size(); ++i) {
    if (i < weights.size()) scaled[i] = weights[i] / sum * n;
    // What rounding leaves without a partner keeps its bin, or has none.
    bins_[i].threshold = scaled[i] > 0 ? 1 : 0;
    bins_[i].alias = scaled[i] > 0 ? i : heaviest;
    (scaled[i] < 1 ? small : large).push_back(i);
  }
  while (!small.empty() && !large.empty()) {
    const std::uint32_t low = small.back();
    const std::uint32_t high = large.back();
    small.pop_back();
    const double threshold = std::ceil(scaled[low] * steps) / steps;
    bins_[low].threshold = static_cast<float>(threshold);
    bins_[low].alias = high;
    scaled[high] -= 1 - threshold;
    if (scaled[high] < 1) {
      large.pop_back();
      small.push_back(high);
    }
  }
  std::vector<double> chances(bins_.size());
  for (std::uint32_t i = 0; i < bins_.size(); ++i) {
    const auto threshold = static_cast<double>(bins_[i].threshold);
    chances[i] += threshold;
    chances[bins_[i].alias] += 1 - threshold;
  }
  for (std::uint32_t i = 0; i < bins_.size(); ++i) bins_[i].probability = static_cast<float>(chances[i] / n);
}

}  // namespace photond
