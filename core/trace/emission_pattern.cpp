#include "core/trace/emission_pattern.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace photond {

namespace {

// Share of the places that are drawn evenly: a texel that no look has met still gets its turn.
constexpr float kFloor = 0.1f;
// Up to this much brighter than the mean, a cell is nearly like the others.
constexpr float kNearly = 1.25f;
// In terms of the brightest cell beside it a cell has so much at least: some of what shines there may reach into it.
constexpr float kBeside = 0.125f;

// For each item the largest of it and of those beside it, `stride` away.
std::vector<float> spread(std::span<const float> items, std::uint32_t side, std::uint32_t stride) {
  std::vector<float> largest(items.begin(), items.end());
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::size_t at = i / stride % side;
    if (at > 0) largest[i] = std::max(largest[i], items[i - stride]);
    if (at + 1 < side) largest[i] = std::max(largest[i], items[i + stride]);
  }
  return largest;
}

}  // namespace

EmissionPattern::EmissionPattern(std::uint32_t side, std::span<const float> radiance) {
  const double sum = std::accumulate(radiance.begin(), radiance.end(), 0.0);
  const auto mean = static_cast<float>(sum / static_cast<double>(radiance.size()));
  if (!(*std::ranges::max_element(radiance) > kNearly * mean)) return;
  side_ = side;
  const std::vector<float> largest = spread(spread(radiance, side, 1), side, side);
  std::vector<float> weights(radiance.size());
  for (std::size_t i = 0; i < weights.size(); ++i) {
    weights[i] = (1 - kFloor) * (std::max(radiance[i], kBeside * largest[i]) / mean) + kFloor;
  }
  cells_ = GridDistribution(side, side, weights);
}

EmissionPattern::Place EmissionPattern::draw(const Vec2& u) const {
  if (even()) return {u, 1};
  const GridDistribution::Place place = cells_.sample(u);
  return {(Vec2(place.x, place.y) + Vec2(place.s, place.t)) / scale(), place.probability * scale() * scale()};
}

float EmissionPattern::density(const Vec2& u) const {
  if (even()) return 1;
  const Vec2 cell = glm::clamp(u * scale(), Vec2(0), Vec2(scale() - 1));
  return cells_.probability(static_cast<std::uint32_t>(cell.x), static_cast<std::uint32_t>(cell.y)) * scale() * scale();
}

}  // namespace photond
