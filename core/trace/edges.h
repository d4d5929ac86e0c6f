#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/math/types.h"
#include "core/scene/scene.h"

namespace photond {

/// Where surfaces end or turn away by more than 60°: the open and sharp edges of all opaque meshes, in world space,
/// in a bounding volume hierarchy. Photons cannot be gathered across them.
class Edges {
 public:
  struct Segment {
    Vec3 a, b;
  };

  Edges() = default;
  explicit Edges(const Scene& scene);

  /// Of what another object has told; copied. Nothing where it cannot be that.
  static std::optional<Edges> of(std::span<const Segment> segments, std::span<const std::byte> nodes);

  std::size_t size() const { return segments_.size(); }
  std::span<const Segment> segments() const { return segments_; }
  std::span<const std::byte> nodes() const { return std::as_bytes(std::span(nodes_)); }
  std::uint64_t memory_bytes() const {
    return segments_.capacity() * sizeof(Segment) + nodes_.capacity() * sizeof(Node);
  }

  /// Calls visit(segment) for every segment whose bounding box comes nearer to `center` than `radius`.
  template <class Visit>
  void near(const Vec3& center, float radius, Visit&& visit) const;

 private:
  static constexpr std::uint32_t kLeafSize = 4;
  struct Node {
    Bounds3 bounds;
    std::uint32_t begin, end;   // of segments_
    std::uint32_t right;        // the left child follows its parent; 0 for a leaf
  };
  std::uint32_t build(std::uint32_t begin, std::uint32_t end);

  std::vector<Segment> segments_;
  std::vector<Node> nodes_;
};

template <class Visit>
void Edges::near(const Vec3& center, float radius, Visit&& visit) const {
  std::array<std::uint32_t, 64> stack;
  std::uint32_t top = 0;
  if (!nodes_.empty()) stack[top++] = 0;
  while (top > 0) {
    const std::uint32_t index = stack[--top];
    const Node& node = nodes_[index];
    const Vec3 outside = glm::max(glm::max(node.bounds.min - center, center - node.bounds.max), Vec3(0));
    if (glm::dot(outside, outside) >= radius * radius) continue;
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) visit(segments_[i]);
    } else {
      stack[top++] = node.right;
      stack[top++] = index + 1;
    }
  }
}

}  // namespace photond
