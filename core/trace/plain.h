#pragma once

#include <cstdint>
#include <vector>

#include "core/math/lanes.h"
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

/// Photons that meet plain surfaces, and how they leave.
struct alignas(64) PlainBounces {
  // What comes in.
  Vec3Lanes a, b, c;             ///< the triangles
  float u[kLanes], v[kLanes];            ///< where on them, as in Hit
  Vec3Lanes albedo;
  Vec3Lanes direction;           ///< of the photon
  Vec3Lanes flux;
  std::uint32_t depth[kLanes];    ///< bounces before this one
  float random[3][kLanes];

  // What goes out.
  Vec3Lanes position;
  std::uint32_t from[kLanes];     ///< encode_direction of where the photon came from
  std::uint32_t normal[kLanes];   ///< encode_normal on that side
  Vec3Lanes origin;              ///< of the next ray
  Vec3Lanes next_direction;
  Vec3Lanes next_flux;           ///< black where Russian roulette ends the path
  float next_power[kLanes];       ///< mean of next_flux

  /// Computes the first `count` bounces: cosine-distributed, surviving in proportion to what is reflected.
  void scatter(std::uint32_t count);
};

}  // namespace photond
