#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace photond {

/// Draws indices in constant time [Walker 1977, Vose 1991]. The probabilities are those that numbers of 24 bits can
/// bring about: small weights are rounded up to the next step of 2⁻²⁴, at the cost of large ones.
class AliasTable {
 public:
  static constexpr std::size_t kMostWeights = std::size_t{1} << 24;

  AliasTable() = default;
  /// `weights`: up to kMostWeights, finite and not negative, with a positive sum.
  explicit AliasTable(std::span<const double> weights);

  std::uint64_t memory_bytes() const { return bins_.size() * sizeof(Bin); }
  /// Probability of an index: exact.
  float pdf(std::size_t index) const { return bins_[index].probability; }
  /// An index for u in [0, 1), a multiple of 2⁻²⁴.
  std::uint32_t sample(float u) const {
    const float scaled = u * static_cast<float>(bins_.size());   // exact
    const auto i = static_cast<std::uint32_t>(scaled);
    const std::uint32_t choices[2] = {bins_[i].alias, i};  // indexed: which one it is no branch can predict
    return choices[scaled - static_cast<float>(i) < bins_[i].threshold];
  }

 private:
  struct Bin {
    float threshold = 1;
    std::uint32_t alias = 0;
    float probability = 0;
  };
  std::vector<Bin> bins_;   // a power of two of them
};

}  // namespace photond
