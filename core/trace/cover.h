#pragma once

#include <span>
#include <vector>

#include "core/scene/scene.h"

namespace photond {

/// Boxes around what some instances hold: a ray that meets any of it crosses the whole and one of the parts.
struct Cover {
  Bounds3 whole;               ///< empty where they hold nothing
  std::vector<Bounds3> parts;  ///< at most kCoverParts; none where most rays that cross the whole cross them, too
};
inline constexpr std::size_t kCoverParts = 16;

/// Around the triangles of these instances; around whole instances where there are very many.
Cover cover(const Scene& scene, std::span<const std::uint32_t> instances);

/// The share of all lines through a box that cross a cover within it, to about 1 %.
float crossing_share(const Cover& cover, const Bounds3& world);

}  // namespace photond
