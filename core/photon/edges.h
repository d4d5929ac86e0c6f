#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "core/base/large_array.h"
#include "core/photon/box_tree.h"
#include "core/scene/scene.h"

namespace photond {

/// Where surfaces end or turn away by more than 60°: the open and sharp edges of all opaque meshes, in world space.
/// Photons cannot be gathered across them.
class Edges {
 public:
  struct Segment {
    Vec3 a, b;
  };

  Edges() = default;
  explicit Edges(const Scene& scene);

  /// Over what another object has told, used where it lies. Nothing where it cannot be that.
  static std::optional<Edges> over(std::span<const Segment> segments, std::span<const std::byte> tree_nodes,
                                   std::shared_ptr<const void> owner);

  std::uint32_t size() const { return size_; }
  /// Along a Morton curve.
  std::span<const Segment> segments() const { return {segments_.get(), size_}; }
  const BoxTree& tree() const { return tree_; }
  std::uint64_t memory_bytes() const { return segments().size_bytes() + tree_.memory_bytes(); }

  /// Calls visit(segment) for every segment whose bounding box comes nearer to `center` than `radius`.
  template <class Visit>
  void near(const Vec3& center, float radius, const Visit& visit) const {
    tree_.query(center, radius * radius, [&](std::span<const std::uint32_t> found) {
      for (const std::uint32_t i : found) visit(segments_[i]);
    });
  }

 private:
  std::uint32_t size_ = 0;
  LargeArray<Segment> segments_;
  BoxTree tree_;
};

}  // namespace photond
