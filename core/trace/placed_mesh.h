#pragma once

#include <cstdint>
#include <vector>

#include "core/scene/scene.h"

namespace photond {

/// What a photon needs first of the instance it meets, in half a cache line.
struct alignas(32) PlacedMesh {
  const glm::uvec3* triangles;
  const Vertex* vertices;
  Rgb albedo{0};
  /// The instance is flat, Lambertian and of one colour (`albedo`), and lies in the world as its mesh does: what
  /// most of a room is made of, and scatters light without a SurfacePoint or a Bsdf.
  bool plain = false;
  bool emissive = false;
  bool in_place = false;                  ///< what SurfaceLanes can do: not moved, no normal texture

  /// Asks the cache for a triangle's indices, then (when those have arrived) for its vertices.
  void prefetch_triangle(std::uint32_t triangle) const { __builtin_prefetch(&triangles[triangle]); }
  void prefetch_vertices(std::uint32_t triangle) const {
    const glm::uvec3& t = triangles[triangle];
    __builtin_prefetch(&vertices[t.x]);
    __builtin_prefetch(&vertices[t.y]);
    __builtin_prefetch(&vertices[t.z]);
  }
};

/// For each instance, and one more for rays that meet none: with one triangle, and not plain. Valid while `scene`
/// lives and its vectors stay where they are.
std::vector<PlacedMesh> placed_meshes(const Scene& scene);

}  // namespace photond
