#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "core/base/large_array.h"
#include "core/base/parallel.h"
#include "core/math/float8.h"

namespace photond {

/// Squared length, the one expression by which all distances of the photon index are computed.
template <class T>
[[gnu::always_inline]] inline T length_sq(const T& x, const T& y, const T& z) {
  return x * x + y * y + z * z;
}

/// A tree of bounding boxes, eight to a node, over leaves that are numbered along a space-filling curve: node i of a
/// level bounds the nodes 8i … 8i+7 of the level below, so no links are stored [Kamel and Faloutsos 1993: packed
/// R-trees]. A node's boxes are tested together and without a branch. It knows the leaves' bounds, not what is in
/// them. Three bytes a point for leaves of eight points.
class BoxTree {
 public:
  static constexpr std::uint32_t kWidth = 8;
  /// The most leaves handed over at once.
  static constexpr std::uint32_t kBatch = 64;

  /// Squared distances to a box or to a point are three products each, which compilers may contract differently:
  /// two units in the last place. Boxes are left out, and bounds derived from distances, with this factor between.
  static constexpr float kSafety = 1 + 4 * std::numeric_limits<float>::epsilon();

  BoxTree() = default;

  /// Over the leaves 0 … leaves−1; to be queried when each of them has been set, and the tree closed.
  explicit BoxTree(std::uint32_t leaves);
  /// The bounds of a leaf. For several threads at once.
  void set(std::uint32_t leaf, const Bounds3& bounds) { nodes_[leaf / kWidth].set(leaf % kWidth, bounds); }
  /// Bounds the leaves' nodes, level by level.
  void close(const Execution& execution);

  /// Over nodes that such a tree of as many leaves has told; nothing where they are too few or too many.
  static std::optional<BoxTree> over(std::uint32_t leaves, std::span<const std::byte> nodes,
                                     std::shared_ptr<const void> owner);
  /// All that is stored.
  std::span<const std::byte> nodes() const { return std::as_bytes(std::span<const Node>(nodes_.get(), node_count_)); }

  std::uint64_t memory_bytes() const { return node_count_ * sizeof(Node); }

  /// Calls visit(span of at most kBatch leaves) until every leaf that may hold a point with d² < radius_sq has been
  /// named exactly once.
  template <class Visit>
  void query(const Vec3& center, float radius_sq, const Visit& visit) const;

 private:
  // Eight boxes; empty ones, which nothing is near to, where there are fewer children.
  struct Node {
    std::array<std::array<float, kWidth>, 3> min;
    std::array<std::array<float, kWidth>, 3> max;

    void set(std::uint32_t child, const Bounds3& box);
    Bounds3 bounds() const;
    // Bit i: whether the box of child i comes nearer than `radius_sq`.
    std::uint32_t near(const Vec3& center, float radius_sq) const;
  };
  // Eight to the eleventh exceeds 2³².
  static constexpr std::uint32_t kMaxLevels = 11;
  static constexpr std::uint32_t kLevelBits = 4;
  // Each level leaves at most seven siblings behind.
  static constexpr std::uint32_t kStack = kMaxLevels * kWidth;
  static std::uint32_t parents(std::uint32_t n) { return n / kWidth + (n % kWidth != 0 ? 1 : 0); }
  // Sets all but the nodes.
  void divide(std::uint32_t leaves);

  std::uint32_t levels_ = 0;
  std::array<std::uint32_t, kMaxLevels> begin_{};   // of each level in nodes_; level 0 holds the leaves' boxes
  std::uint32_t node_count_ = 0;
  LargeArray<Node> nodes_;
};

inline void BoxTree::Node::set(std::uint32_t child, const Bounds3& box) {
  for (int axis = 0; axis < 3; ++axis) {
    min[axis][child] = box.min[axis];
    max[axis][child] = box.max[axis];
  }
}

inline Bounds3 BoxTree::Node::bounds() const {
  const auto corners = [](const std::array<std::array<float, kWidth>, 3>& c) -> Vec3x8 {
    return {load8(c[0].data()), load8(c[1].data()), load8(c[2].data())};
  };
  return bounds8(corners(min), corners(max));
}

inline std::uint32_t BoxTree::Node::near(const Vec3& center, float radius_sq) const {
  const auto outside = [](const std::array<float, kWidth>& low, const std::array<float, kWidth>& high, float c)
      __attribute__((always_inline)) {
        return max8(max8(load8(low.data()) - c, c - load8(high.data())), Float8{});
      };
  const Float8 d = length_sq(outside(min[0], max[0], center.x), outside(min[1], max[1], center.y),
                             outside(min[2], max[2], center.z));
  return bits8(d < radius_sq);
}

inline void BoxTree::divide(std::uint32_t leaves) {
  assert(leaves < 1u << 31);   // nodes and levels share a word
  if (leaves == 0) return;
  std::uint32_t n = leaves;
  do {
    n = parents(n);
    begin_[levels_++] = node_count_;
    node_count_ += n;
  } while (n > 1);
}

inline std::optional<BoxTree> BoxTree::over(std::uint32_t leaves, std::span<const std::byte> nodes,
                                            std::shared_ptr<const void> owner) {
  BoxTree tree;
  tree.divide(leaves);
  if (nodes.size() != tree.memory_bytes()) return std::nullopt;
  const std::span<const Node> view(reinterpret_cast<const Node*>(nodes.data()), tree.node_count_);
  tree.nodes_ = view_large_array(view, std::move(owner));
  return tree;
}

inline BoxTree::BoxTree(std::uint32_t leaves) {
  divide(leaves);
  nodes_ = make_large_array<Node>(node_count_);
  for (std::uint32_t absent = leaves; absent % kWidth != 0; ++absent) set(absent, {});
}

inline void BoxTree::close(const Execution& execution) {
  for (std::uint32_t level = 1; level < levels_; ++level) {
    const Node* const children = &nodes_[begin_[level - 1]];
    const std::uint32_t count = begin_[level] - begin_[level - 1];
    parallel_for(execution, parents(count), 256, [&](std::size_t i) {
      for (std::uint32_t c = 0; c < kWidth; ++c) {
        const auto child = static_cast<std::uint32_t>(i) * kWidth + c;
        nodes_[begin_[level] + i].set(c, child < count ? children[child].bounds() : Bounds3());
      }
    });
  }
}

template <class Visit>
void BoxTree::query(const Vec3& center, float radius_sq, const Visit& visit) const {
  // Of what is still to be looked at: the node's number and its level, as one word, which a processor that has just
  // written it reads without waiting.
  std::array<std::uint32_t, kStack> stack;
  std::array<std::uint32_t, kBatch + kWidth> leaves;
  std::uint32_t top = 0;
  std::uint32_t count = 0;
  const float reach_sq = radius_sq * kSafety;
  if (levels_ > 0) stack[top++] = levels_ - 1;
  while (top > 0) {
    const std::uint32_t pending = stack[--top];
    const std::uint32_t number = pending >> kLevelBits, level = pending & ((1u << kLevelBits) - 1);
    const std::uint32_t near = nodes_[begin_[level] + number].near(center, reach_sq);
    if (level > 0) {
      top += put_set8(near, (number * kWidth << kLevelBits) + level - 1, 1 << kLevelBits, &stack[top]);
      continue;
    }
    count += put_set8(near, number * kWidth, 1, &leaves[count]);
    if (count > kBatch - kWidth) {
      visit(std::span<const std::uint32_t>(leaves.data(), count));
      count = 0;
    }
  }
  if (count > 0) visit(std::span<const std::uint32_t>(leaves.data(), count));
}

}  // namespace photond
