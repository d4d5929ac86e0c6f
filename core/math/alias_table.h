#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace photond {

/// Draws indices with given probabilities in constant time [Walker 1977, Vose 1991].
class AliasTable {
 public:
  AliasTable() = default;
  /// `weights` must be finite and not negative, with a positive sum.
  explicit AliasTable(std::span<const double> weights);

  bool empty() const { return bins_.empty(); }
  std::size_t size() const { return bins_.size(); }
  /// Probability of an index.
  float pdf(std::size_t index) const { return bins_[index].probability; }
  /// An index for u in [0, 1).
  std::uint32_t sample(float u) const {
    const float scaled = u * static_cast<float>(bins_.size());
    const auto i = std::min(static_cast<std::uint32_t>(scaled), static_cast<std::uint32_t>(bins_.size()) - 1);
    const std::uint32_t choices[2] = {bins_[i].alias, i};  // indexed: which one it is no branch can predict
    return choices[scaled - static_cast<float>(i) < bins_[i].threshold];
  }

 private:
  struct Bin {
    float threshold = 1;
    std::uint32_t alias = 0;
    float probability = 0;
  };
  std::vector<Bin> bins_;
};

}  // namespace photond
