#include "core/photon/bandwidth.h"

#include <algorithm>
#include <vector>

#include "core/photon/nearest.h"

namespace photond {

namespace {

constexpr std::uint32_t kNeighbours = 16;

}  // namespace

Bandwidth::Bandwidth(std::shared_ptr<const PhotonMaps> pilot, const PhotonMap* map, const Execution& execution)
    : pilot_(std::move(pilot)), map_(map) {
  if (map_->size() < kNeighbours) return;
  count_ = map_->size();
  density_ = make_large_array<float>(count_);
  parallel_for(execution, count_, 256, [&](std::size_t i) {
    const float r_sq =
        nearest_radius_sq(*map_, map_->position(static_cast<std::uint32_t>(i)), kNeighbours, kInfinity);
    density_[i] = static_cast<float>(kNeighbours - 1) / (kPi * std::max(r_sq, 1e-30f));
  });
}

std::optional<Bandwidth> Bandwidth::over(std::shared_ptr<const PhotonMaps> pilot, const PhotonMap* map,
                                         std::span<const float> densities, std::shared_ptr<const void> owner) {
  Bandwidth bandwidth;
  if (densities.size() != (map->size() < kNeighbours ? 0 : map->size())) return std::nullopt;
  bandwidth.pilot_ = std::move(pilot);
  bandwidth.map_ = map;
  bandwidth.count_ = static_cast<std::uint32_t>(densities.size());
  bandwidth.density_ = view_large_array(densities, std::move(owner));
  return bandwidth;
}

float Bandwidth::median() const {
  if (count_ == 0) return 0;
  std::vector<float> sorted(density_.get(), density_.get() + count_);
  const auto middle = sorted.begin() + count_ / 2;
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

float Bandwidth::radius_sq(const Vec3& point, float photons) const {
  if (count_ == 0) return 0;
  // The nearest photon of three leaves along the curve: a neighbour, if not always the nearest of all.
  const std::uint32_t middle = map_->near_leaf(point);
  std::uint32_t nearest = 0;
  float found = kInfinity;
  for (std::uint32_t leaf = middle - std::min(middle, 1u); leaf < std::min(middle + 2, map_->leaf_count()); ++leaf) {
    const PhotonLeaf::Lanes<float> d = map_->leaf(leaf).distances_sq(point);
    for (std::uint32_t i = 0; i < PhotonLeaf::kSize; ++i) {
      if (d[i] >= found) continue;
      found = d[i];
      nearest = leaf * PhotonLeaf::kSize + i;
    }
  }
  return photons / (kPi * density_[nearest]);
}

}  // namespace photond
