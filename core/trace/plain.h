#pragma once

#include <cstdint>

#include "core/math/lanes.h"
#include "core/math/rng.h"
#include "core/trace/flat_point.h"

namespace photond {

/// Photons that meet plain surfaces, and how they leave.
struct alignas(64) PlainBounces {
  // What comes in.
  TriangleLanes at;
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

  /// Fills lane k.
  void set(std::uint32_t k, const PlacedMesh& mesh, const Hit& hit, const Vec3& in, const Rgb& power,
           std::uint32_t bounces, Rng& rng) {
    at.set(k, mesh, hit);
    albedo.set(k, mesh.albedo);
    direction.set(k, in);
    flux.set(k, power);
    depth[k] = bounces;
    for (auto& number : random) number[k] = rng.next();
  }
  /// Computes the first `count` bounces: cosine-distributed, surviving in proportion to what is reflected.
  void scatter(std::uint32_t count);
};

}  // namespace photond
