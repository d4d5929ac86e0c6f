#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/parallel.h"
#include "core/math/types.h"

namespace photond {

/// A balanced kd-tree over points, with buckets of at most kLeafSize points and no stored child links: node i has
/// the children 2i+1 and 2i+2, and a node's points are the halves of its parent's range. Points are kept in leaf
/// order as three arrays, so that a leaf's distances are computed several at a time. Median splits of the longest
/// side [Bentley 1975]; about 13 bytes a point.
class KdTree {
 public:
  static constexpr std::uint32_t kLeafSize = 12;

  KdTree() = default;

  /// Builds the tree and writes to `order` which input point stands at each place of the tree's arrays. Ties are
  /// broken by input index, so the result does not depend on the execution.
  static KdTree build(std::span<const Vec3> points, const Execution& execution, std::vector<std::uint32_t>& order);

  std::uint32_t size() const { return static_cast<std::uint32_t>(x_.size()); }
  Vec3 point(std::uint32_t i) const { return {x_[i], y_[i], z_[i]}; }
  std::uint64_t memory_bytes() const {
    return (x_.capacity() + y_.capacity() + z_.capacity()) * sizeof(float) + split_.capacity() * sizeof(float) +
           axis_.capacity();
  }

  /// The one traversal: calls visit(i, d²) for every point with d² < radius_sq, nearer subtrees first. `visit`
  /// takes the radius by reference and may shrink it (k nearest) or leave it (fixed radius).
  template <class Visit>
  void query(const Vec3& center, float radius_sq, Visit&& visit) const;

 private:
  struct Builder;

  std::uint32_t depth_ = 0;            // levels of inner nodes
  std::vector<float> split_;           // 2^depth − 1 inner nodes in level order
  std::vector<std::uint8_t> axis_;
  std::vector<float> x_, y_, z_;       // in leaf order
};

template <class Visit>
void KdTree::query(const Vec3& center, float radius_sq, Visit&& visit) const {
  struct Pending {
    std::uint32_t node, begin, end;
    float distance_sq;                 // from the center to the node's side of its parent's plane
  };
  std::array<Pending, 40> stack;
  std::uint32_t top = 0;
  if (size() > 0) stack[top++] = {0, 0, size(), 0};
  const auto inner = static_cast<std::uint32_t>(split_.size());
  while (top > 0) {
    auto [node, begin, end, distance_sq] = stack[--top];
    if (distance_sq >= radius_sq) continue;
    while (node < inner) {
      const std::uint32_t middle = begin + (end - begin) / 2;
      const float offset = center[axis_[node]] - split_[node];
      const bool right = offset >= 0;
      const std::uint32_t near = 2 * node + (right ? 2 : 1);
      const std::uint32_t far = 2 * node + (right ? 1 : 2);
      const float plane_sq = std::max(distance_sq, offset * offset);
      if (plane_sq < radius_sq) {
        stack[top++] = right ? Pending{far, begin, middle, plane_sq} : Pending{far, middle, end, plane_sq};
      }
      (right ? begin : end) = middle;
      node = near;
    }
    std::array<float, kLeafSize> d;
    const std::uint32_t count = end - begin;
    for (std::uint32_t i = 0; i < count; ++i) {
      const float dx = x_[begin + i] - center.x;
      const float dy = y_[begin + i] - center.y;
      const float dz = z_[begin + i] - center.z;
      d[i] = dx * dx + dy * dy + dz * dz;
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      if (d[i] < radius_sq) visit(begin + i, d[i], radius_sq);
    }
  }
}

}  // namespace photond
