#pragma once

#include <cstdint>
#include <vector>

#include "core/math/lanes.h"
#include "core/scene/scene.h"

namespace photond {

/// An instance that is flat, Lambertian and of one colour, and lies in the world as its mesh does: what most of a
/// room is made of, and scatters light without a SurfacePoint or a Bsdf.
struct PlainInstance {
  const glm::uvec3* triangles = nullptr;  ///< null: the instance is not plain
  const Vertex* vertices = nullptr;
  Rgb albedo{0};

  explicit operator bool() const { return triangles != nullptr; }
};

/// For each instance, and one more that is not plain, for a ray that meets nothing. Valid while `scene` lives and its vectors stay where they are.
std::vector<PlainInstance> plain_instances(const Scene& scene);

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
