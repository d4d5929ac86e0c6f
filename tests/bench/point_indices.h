#pragma once

// Indices that the core does not use, kept short, so that its choice can be measured again.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <tbb/parallel_invoke.h>

#include "core/photon/morton_order.h"

namespace photond::bench {

/// Points component by component in an index's order; eight more than there are, so that loops may overrun.
struct Points {
  std::vector<float> x, y, z;

  void set(std::uint32_t n, const Execution& execution, const auto& position) {
    for (auto* component : {&x, &y, &z}) component->resize(n + 8, kInfinity);
    parallel_for(execution, n, 4096, [&](std::size_t i) {
      const Vec3 p = position(i);
      x[i] = p.x;
      y[i] = p.y;
      z[i] = p.z;
    });
  }

  /// visit(eight squared distances) for the points [begin, end); infinite beyond the end.
  void distances(std::uint32_t begin, std::uint32_t end, const Vec3& center, const auto& visit) const {
    for (std::uint32_t first = begin; first < end; first += 8) {
      std::array<float, 8> d;
      for (std::uint32_t i = 0; i < 8; ++i) {
        const float d_sq = length_sq(x[first + i] - center.x, y[first + i] - center.y, z[first + i] - center.z);
        d[i] = first + i < end ? d_sq : kInfinity;
      }
      visit(d);
    }
  }
  static float length_sq(float a, float b, float c) { return a * a + b * b + c * c; }
};

/// The k smallest distances in a heap; bounds the radius as soon as there are k.
class NearestHeap {
 public:
  explicit NearestHeap(std::uint32_t k) : k_(k) {}
  void add(const std::array<float, 8>& distances, float& radius_sq) {
    for (const float d : distances) {
      if (!(d < radius_sq)) continue;
      if (heap_.size() == k_) {
        std::pop_heap(heap_.begin(), heap_.end());
        heap_.pop_back();
      }
      heap_.push_back(d);
      std::push_heap(heap_.begin(), heap_.end());
      if (heap_.size() == k_) radius_sq = heap_.front();
    }
  }
  bool full() const { return heap_.size() == k_; }
  float kth() const { return heap_.front(); }

 private:
  std::uint32_t k_;
  std::vector<float> heap_;
};

/// Balanced, medians of the longest side, leaves of at most sixteen [Bentley 1975].
class KdTree {
 public:
  KdTree(std::span<const Photon> photons, const Execution& execution)
      : size_(static_cast<std::uint32_t>(photons.size())) {
    while ((size_ >> depth_) >= kLeaf) ++depth_;
    split_.resize((std::size_t{1} << depth_) - 1);
    axis_.resize(split_.size());
    std::vector<Vec3> positions(size_);
    for (std::uint32_t i = 0; i < size_; ++i) positions[i] = photons[i].position;
    const auto run = [&] { build(positions, 0, 0, size_); };
    execution.arena == nullptr ? run() : execution.arena->execute(run);
    points_.set(size_, execution, [&](std::size_t i) { return positions[i]; });
  }

  std::uint64_t memory_bytes() const { return split_.size() * 5 + 12ull * size_; }

  /// visit(eight squared distances, radius_sq) of all points that may be within; nearer subtrees first.
  void query(const Vec3& center, float radius_sq, const auto& visit) const {
    descend(0, 0, size_, 0, center, radius_sq, visit);
  }
  float nearest_radius_sq(const Vec3& center, std::uint32_t k) const {
    NearestHeap heap(k);
    query(center, kInfinity, [&](const auto& d, float& radius_sq) { heap.add(d, radius_sq); });
    return heap.kth();
  }

 private:
  static constexpr std::uint32_t kLeaf = 16;

  void build(std::vector<Vec3>& p, std::uint32_t node, std::uint32_t begin, std::uint32_t end) {
    if (node >= split_.size()) return;
    Bounds3 bounds;
    for (std::uint32_t i = begin; i < end; ++i) bounds.add(p[i]);
    const Vec3 extent = bounds.extent();
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(p.begin() + begin, p.begin() + middle, p.begin() + end,
                     [axis](const Vec3& a, const Vec3& b) { return a[axis] < b[axis]; });
    axis_[node] = static_cast<std::uint8_t>(axis);
    split_[node] = p[middle][axis];
    tbb::parallel_invoke([&] { build(p, 2 * node + 1, begin, middle); }, [&] { build(p, 2 * node + 2, middle, end); });
  }

  void descend(std::uint32_t node, std::uint32_t begin, std::uint32_t end, float distance_sq, const Vec3& center,
               float& radius_sq, const auto& visit) const {
    if (distance_sq >= radius_sq) return;
    if (node >= split_.size()) {
      points_.distances(begin, end, center, [&](const auto& d) { visit(d, radius_sq); });
      return;
    }
    const std::uint32_t middle = begin + (end - begin) / 2;
    const float offset = center[axis_[node]] - split_[node];
    const float far_sq = std::max(distance_sq, offset * offset);
    const auto left = [&](float d_sq) { descend(2 * node + 1, begin, middle, d_sq, center, radius_sq, visit); };
    const auto right = [&](float d_sq) { descend(2 * node + 2, middle, end, d_sq, center, radius_sq, visit); };
    offset < 0 ? (left(distance_sq), right(far_sq)) : (right(distance_sq), left(far_sq));
  }

  std::uint32_t size_;
  std::uint32_t depth_ = 0;
  std::vector<float> split_;
  std::vector<std::uint8_t> axis_;
  Points points_;
};

/// Cubic cells in rows, points sorted by cell; as many cells as make eight points a cell that holds any, but at most
/// four a point.
class SortedGrid {
 public:
  SortedGrid(std::span<const Photon> photons, const Execution& execution) {
    const auto n = static_cast<std::uint32_t>(photons.size());
    for (const Photon& photon : photons) bounds_.add(photon.position);
    const float side = std::max(max_component(bounds_.extent()), std::numeric_limits<float>::min());
    for (std::uint32_t cells = 4;; cells = cells * 5 / 4) {     // along the longest side
      scale_ = static_cast<float>(cells) / side;
      dims_ = glm::ivec3(bounds_.extent() * scale_) + 1;
      start_.assign(static_cast<std::size_t>(dims_.x) * dims_.y * dims_.z + 1, 0);
      for (const Photon& photon : photons) ++start_[cell(photon.position)];
      const auto used = start_.size() - static_cast<std::size_t>(std::count(start_.begin(), start_.end(), 0u));
      if (n < 8 * used || 2 * start_.size() > 4ull * n) break;
    }
    std::uint32_t sum = 0;
    for (std::uint32_t& count : start_) sum += std::exchange(count, sum);
    std::vector<std::uint32_t> next = start_;
    std::vector<std::uint32_t> order(n);
    for (std::uint32_t i = 0; i < n; ++i) order[next[cell(photons[i].position)]++] = i;
    points_.set(n, execution, [&](std::size_t i) { return photons[order[i]].position; });
  }

  std::uint64_t memory_bytes() const { return start_.size() * 4 + 12ull * points_.x.size(); }

  void query(const Vec3& center, float radius_sq, const auto& visit) const {
    const float radius = std::min(std::sqrt(radius_sq), 4 * bounds_.radius() + glm::distance(center, bounds_.center()));
    const glm::ivec3 low = cell_of(center - radius);
    const glm::ivec3 high = cell_of(center + radius);
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        const std::size_t row = (static_cast<std::size_t>(z) * dims_.y + y) * dims_.x;
        points_.distances(start_[row + low.x], start_[row + high.x + 1], center,
                          [&](const auto& d) { visit(d, radius_sq); });
      }
    }
  }
  // Doubles the radius, from a cell's, until k are found.
  float nearest_radius_sq(const Vec3& center, std::uint32_t k) const {
    for (float radius_sq = 0.25f / (scale_ * scale_);; radius_sq *= 4) {
      NearestHeap heap(k);
      query(center, radius_sq, [&](const auto& d, float& r_sq) { heap.add(d, r_sq); });
      if (heap.full()) return heap.kth();
    }
  }

 private:
  glm::ivec3 cell_of(const Vec3& p) const {
    return glm::clamp(glm::ivec3(glm::clamp((p - bounds_.min) * scale_, Vec3(-1), Vec3(dims_))), glm::ivec3(0), dims_ - 1);
  }
  std::size_t cell(const Vec3& p) const {
    const glm::ivec3 c = cell_of(p);
    return (static_cast<std::size_t>(c.z) * dims_.y + c.y) * dims_.x + c.x;
  }

  Bounds3 bounds_;
  float scale_ = 1;
  glm::ivec3 dims_{1};
  std::vector<std::uint32_t> start_;
  Points points_;
};

/// Points in Morton order beside their codes: a cell is the range of codes with its prefix, found by bisection.
class ImplicitOctree {
 public:
  ImplicitOctree(std::span<const Photon> photons, const Execution& execution) {
    std::vector<std::span<const Photon>> blocks;
    for (std::size_t i = 0; i < photons.size(); i += PhotonKey::kMaxSpan) {
      blocks.push_back(photons.subspan(i, std::min(PhotonKey::kMaxSpan, photons.size() - i)));
    }
    for (const Photon& photon : photons) bounds_.add(photon.position);
    const MortonGrid grid(bounds_);
    const auto order = morton_order(blocks, grid, 0, execution);
    codes_.resize(photons.size());
    points_.set(static_cast<std::uint32_t>(photons.size()), execution, [&](std::size_t i) {
      const Vec3 position = order[i].of(blocks).position;
      codes_[i] = grid.code(position);
      return position;
    });
  }

  std::uint64_t memory_bytes() const { return 20ull * codes_.size(); }

  void query(const Vec3& center, float radius_sq, const auto& visit) const {
    const float side = max_component(bounds_.extent());
    const auto end = static_cast<std::uint32_t>(codes_.size());
    descend(0, end, bounds_.min, side, 3 * (MortonGrid::kAxisBits - 1), center, radius_sq, visit);
  }
  float nearest_radius_sq(const Vec3& center, std::uint32_t k) const {
    NearestHeap heap(k);
    query(center, kInfinity, [&](const auto& d, float& radius_sq) { heap.add(d, radius_sq); });
    return heap.kth();
  }

 private:
  void descend(std::uint32_t begin, std::uint32_t end, const Vec3& min, float side, int shift, const Vec3& center,
               float& radius_sq, const auto& visit) const {
    // Codes are rounded: a cell may hold points a little outside.
    const float slack = 2e-7f * max_component(bounds_.extent());
    const Vec3 apart = glm::max(glm::max(min - center, center - (min + side)) - slack, Vec3(0));
    if (begin == end || glm::dot(apart, apart) >= radius_sq) return;
    if (end - begin <= 16 || shift < 0) {
      points_.distances(begin, end, center, [&](const auto& d) { visit(d, radius_sq); });
      return;
    }
    std::array<std::uint32_t, 9> bound{begin};
    for (std::uint32_t child = 0; child < 8; ++child) {
      const auto beyond = [&](std::uint64_t code) { return ((code >> shift) & 7) <= child; };
      bound[child + 1] = static_cast<std::uint32_t>(
          std::partition_point(codes_.begin() + bound[child], codes_.begin() + end, beyond) - codes_.begin());
    }
    const float half = side / 2;
    const auto bit = [&](int axis) { return center[axis] >= min[axis] + half ? 4u >> axis : 0u; };
    const std::uint32_t near = bit(0) | bit(1) | bit(2);
    for (std::uint32_t i = 0; i < 8; ++i) {                     // the center's cell first, the opposite one last
      const std::uint32_t child = i ^ near;
      const Vec3 corner = min + half * Vec3(child >> 2 & 1, child >> 1 & 1, child & 1);
      descend(bound[child], bound[child + 1], corner, half, shift - 3, center, radius_sq, visit);
    }
  }

  Bounds3 bounds_;
  std::vector<std::uint64_t> codes_;
  Points points_;
};

}  // namespace photond::bench
