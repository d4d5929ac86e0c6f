#pragma once

#include <cstdint>
#include <vector>

#include "core/scene/scene.h"

namespace photond {

/// How an instance of one colour scatters light, where that can be computed for several rays side by side.
enum class Shading : std::uint32_t {
  other,     ///< by a Bsdf
  diffuse,   ///< Lambert
  mirror,    ///< ideal metal
  glass,     ///< smooth and clear: reflects or refracts by Fresnel's equations, what is refracted takes the colour
};

/// What a path needs first of the instance it meets, in a cache line.
struct alignas(64) PlacedMesh {
  const glm::uvec3* triangles;
  const Vertex* vertices;
  Rgb albedo{0};
  /// The instance is flat, Lambertian and of one colour (`albedo`), and lies in the world as its mesh does: what
  /// most of a room is made of, and scatters light without a SurfacePoint or a Bsdf.
  bool plain = false;
  bool emissive = false;
  bool in_place = false;                  ///< what SurfaceLanes can do: not moved, no normal texture
  Shading shading = Shading::other;       ///< other, too, where not `in_place`
  float ior = 1;                          ///< of glass

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
