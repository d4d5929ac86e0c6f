#include "core/math/alias_table.h"

#include <algorithm>
#include <numeric>

namespace photond {

AliasTable::AliasTable(std::span<const double> weights) : bins_(weights.size()) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  const double n = static_cast<double>(weights.size());
  std::vector<double> scaled(weights.size());
  std::vector<std::uint32_t> small;
  std::vector<std::uint32_t> large;
  for (std::uint32_t i = 0; i < weights.size(); ++i) {
    bins_[i].probability = static_cast<float>(weights[i] / sum);
    bins_[i].alias = i;
    scaled[i] = weights[i] / sum * n;
    (scaled[i] < 1 ? small : large).push_back(i);
  }
  while (!small.empty() && !large.empty()) {
    const std::uint32_t low = small.back();
    const std::uint32_t high = large.back();
    small.pop_back();
    bins_[low].threshold = static_cast<float>(scaled[low]);
    bins_[low].alias = high;
    scaled[high] -= 1 - scaled[low];
    if (scaled[high] < 1) {
      large.pop_back();
      small.push_back(high);
    }
  }
}

}  // namespace photond
