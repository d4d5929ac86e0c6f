#pragma once

#include "core/render/camera_path.h"
#include "core/render/camera_sampler.h"
#include "core/trace/flat_point.h"

namespace photond {

/// Where paths from the camera meet plain surfaces (PlacedMesh::plain): the light that comes there straight from the
/// lights, weighted against going on, and how they go on. What a path tracer does there, for several at a time.
struct alignas(64) PlainVertices {
  // What comes in.
  TriangleLanes at;
  Vec3Lanes albedo;
  Vec3Lanes direction, throughput;   ///< of the paths
  float compression[kLanes];
  std::uint32_t depth[kLanes];
  SamplerLanes samplers;

  // What goes out.
  RayLanes shadow;                   ///< towards a light
  Vec3Lanes light;                   ///< that comes from there, times the path's throughput; black where none comes
  Vec3Lanes origin, next_direction;  ///< of the next ray
  Vec3Lanes next_throughput;         ///< black where Russian roulette ends the path
  float next_pdf[kLanes];            ///< CameraPath::last_pdf

  /// Fills lane k.
  void set(std::uint32_t k, const PlacedMesh& mesh, const Hit& hit, const CameraPath& path, CameraSampler& sampler) {
    at.set(k, mesh, hit);
    albedo.set(k, mesh.albedo);
    direction.set(k, path.ray.direction);
    throughput.set(k, path.throughput);
    compression[k] = path.compression;
    depth[k] = path.depth;
    samplers.set(k, sampler, kPairs);
  }
  /// Computes the first `count`.
  void shade(const PreparedScene& scene, std::uint32_t count);

 private:
  void find_points(std::uint32_t count);
  void sample_lights(const PreparedScene& scene, std::uint32_t count);
  void light_points(std::uint32_t count);
  void scatter(std::uint32_t count);

  static constexpr std::uint32_t kPairs = 3;   // of random numbers
  Vec3Lanes position_, ng_;
  float extent_[kLanes];
  float choice_[kLanes], roulette_[kLanes];
  float random_[2][kLanes];
  DirectLanes direct_;
};

}  // namespace photond
