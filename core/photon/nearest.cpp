// Jensen 1996. García et al. 2012: k-nearest normalization.
#include "core/photon/nearest.h"

#include <algorithm>
#include <bit>
#include <cassert>

namespace photond {

namespace {

constexpr std::uint32_t kLeaf = PhotonLeaf::kSize;

// The k-th smallest of non-negative numbers, bit by bit: as ordered as their bits, and counted without a branch.
float kth_smallest(std::span<const float> values, std::uint32_t k) {
  std::uint32_t low = 0;
  std::uint32_t high = std::bit_cast<std::uint32_t>(kInfinity);
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2;
    std::uint32_t count = 0;
    for (const float value : values) count += std::bit_cast<std::uint32_t>(value) <= middle ? 1 : 0;
    (count >= k ? high : low) = count >= k ? middle : middle + 1;
  }
  return std::bit_cast<float>(low);
}

// Photons per k among which the search is first bounded.
constexpr std::uint32_t kWindow = 2;

// The k smallest distances below a radius.
class Nearest {
 public:
  Nearest(const Vec3& center, std::uint32_t k, float radius_sq) : center_(center), k_(k), radius_sq_(radius_sq) {}

  void add(const PhotonLeaf& leaf) {
    if (count_ + kLeaf > found_.size()) keep_k();
    for (const float d : leaf.distances_sq(center_)) {
      found_[count_] = d;
      count_ += d < radius_sq_ ? 1 : 0;
    }
  }

  // Forgets the photons but for the radius they give.
  void start_again() {
    radius_sq_ = std::min(radius_sq_, kth() * BoxTree::kSafety);
    count_ = 0;
  }

  float radius_sq() const { return radius_sq_; }

  // The k-th distance; the radius where there are fewer.
  float kth() const { return count_ < k_ ? radius_sq_ : kth_smallest({found_.data(), count_}, k_); }

 private:
  void keep_k() {
    std::nth_element(found_.begin(), found_.begin() + (k_ - 1), found_.begin() + count_);
    count_ = k_;
  }

  Vec3 center_;
  std::uint32_t k_;
  float radius_sq_;
  std::uint32_t count_ = 0;
  std::array<float, 3 * kMaxNearest> found_;
};

}  // namespace

float nearest_radius_sq(const PhotonMap& map, const Vec3& center, std::uint32_t k, float max_radius_sq) {
  assert(k >= 1 && k <= kMaxNearest);
  if (map.size() < k) return max_radius_sq;
  Nearest nearest(center, k, max_radius_sq);
  const std::uint32_t window = kWindow * k / kLeaf + 4;
  const std::uint32_t near = map.near_leaf(center);
  const std::uint32_t begin = near - std::min(near, window / 2);
  const std::uint32_t end = std::min(begin + window, map.leaf_count());
  for (std::uint32_t leaf = begin; leaf < end; ++leaf) nearest.add(map.leaf(leaf));
  nearest.start_again();
  map.tree().query(center, nearest.radius_sq(), [&](std::span<const std::uint32_t> leaves) {
    for (const std::uint32_t leaf : leaves) nearest.add(map.leaf(leaf));
  });
  return nearest.kth();
}

}  // namespace photond
