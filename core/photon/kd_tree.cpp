#include "core/photon/kd_tree.h"

#include <algorithm>

#include <tbb/parallel_invoke.h>

namespace photond {

namespace {

struct Item {
  Vec3 position;
  std::uint32_t index;
};

}  // namespace

struct KdTree::Builder {
  KdTree& tree;
  std::vector<Item>& items;

  // Below this many points a task is not worth its start.
  static constexpr std::uint32_t kSerial = 8192;

  void build(std::uint32_t node, std::uint32_t begin, std::uint32_t end, bool parallel) {
    if (node >= tree.split_.size()) return;
    const std::uint32_t middle = begin + (end - begin) / 2;
    const int axis = longest_axis(begin, end);
    const auto less = [axis](const Item& a, const Item& b) {
      return a.position[axis] != b.position[axis] ? a.position[axis] < b.position[axis] : a.index < b.index;
    };
    std::nth_element(items.begin() + begin, items.begin() + middle, items.begin() + end, less);
    tree.axis_[node] = static_cast<std::uint8_t>(axis);
    tree.split_[node] = items[middle].position[axis];
    const bool fork = parallel && end - begin > kSerial;
    const auto left = [&] { build(2 * node + 1, begin, middle, fork); };
    const auto right = [&] { build(2 * node + 2, middle, end, fork); };
    if (fork) {
      tbb::parallel_invoke(left, right);
    } else {
      left();
      right();
    }
  }

  int longest_axis(std::uint32_t begin, std::uint32_t end) const {
    Bounds3 bounds;
    for (std::uint32_t i = begin; i < end; ++i) bounds.add(items[i].position);
    const Vec3 extent = bounds.extent();
    if (extent.x >= extent.y && extent.x >= extent.z) return 0;
    return extent.y >= extent.z ? 1 : 2;
  }
};

KdTree KdTree::build(std::span<const Vec3> points, const Execution& execution, std::vector<std::uint32_t>& order) {
  KdTree tree;
  const auto n = static_cast<std::uint32_t>(points.size());
  // Every leaf must hold at most kLeafSize: the largest of 2^d halves of n is ⌈n/2^d⌉.
  while ((static_cast<std::uint64_t>(n) + (1ULL << tree.depth_) - 1) >> tree.depth_ > kLeafSize) ++tree.depth_;
  const std::size_t inner = n == 0 ? 0 : (std::size_t{1} << tree.depth_) - 1;
  tree.split_.resize(inner);
  tree.axis_.resize(inner);

  std::vector<Item> items(n);
  for (std::uint32_t i = 0; i < n; ++i) items[i] = {points[i], i};
  Builder builder{tree, items};
  const auto run = [&] { builder.build(0, 0, n, execution.arena != nullptr); };
  if (execution.arena != nullptr) {
    execution.arena->execute(run);
  } else {
    run();
  }

  tree.x_.resize(n);
  tree.y_.resize(n);
  tree.z_.resize(n);
  order.resize(n);
  parallel_for(execution, n, 4096, [&](std::size_t i) {
    tree.x_[i] = items[i].position.x;
    tree.y_[i] = items[i].position.y;
    tree.z_[i] = items[i].position.z;
    order[i] = items[i].index;
  });
  return tree;
}

}  // namespace photond
