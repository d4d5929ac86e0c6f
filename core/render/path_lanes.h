#pragma once

#include "core/render/bounces.h"
#include "core/trace/surface.h"

namespace photond {

/// Paths from the camera, side by side, and the vertices where they are: what a path tracer does there.
struct alignas(64) PathLanes {
  // As in CameraPath and Walk.
  RayLanes ray;                      ///< t_max is infinite
  Vec3Lanes throughput;
  float compression[kLanes];
  float last_pdf[kLanes];
  std::uint32_t depth[kLanes];
  SamplerLanes samplers;
  std::uint32_t sample[kLanes];
  Medium medium[kLanes];

  // The vertices.
  SurfaceLanes surfaces;
  Vec3Lanes albedo;
  float ior[kLanes];
  Shading shading[kLanes];

  // Direct light there; black where there is none.
  RayLanes shadow;
  Vec3Lanes light;                   ///< times throughput

  /// Begins a path in lane k.
  void begin(std::uint32_t k, const Ray& camera_ray, const CameraSampler& sampler, std::uint32_t index,
             const Medium& start);
  /// The path in lane k.
  Walk walk(std::uint32_t k) const;
  /// Puts one there.
  void set(std::uint32_t k, const Walk& walk);
  /// Copies a path.
  void copy(std::uint32_t from, std::uint32_t to);

  /// Lets path k arrive at a hit of the mesh.
  void arrive(std::uint32_t k, const PlacedMesh& mesh, const Hit& hit) {
    surfaces.set(k, mesh, hit);
    albedo.set(k, mesh.albedo);
    ior[k] = mesh.ior;
    shading[k] = mesh.shading;
  }
  /// Computes the first `count` surfaces.
  void find_surfaces(std::uint32_t count) {
    surfaces.direction = ray.direction;
    surfaces.compute(count);
  }
  /// Lets the first `count` paths go on, with black throughput where they end; and computes direct light to `diffuse`
  /// surfaces among them. Those of Shading::other are left in an undefined state.
  void bounce(const PreparedScene& scene, std::uint32_t count, std::span<const std::uint32_t> diffuse);

 private:
  void sample_lights(const PreparedScene& scene, std::uint32_t count, std::span<const std::uint32_t> diffuse);
  void light_surfaces(std::uint32_t count);
  void scatter(std::uint32_t count);
  void reflect(std::uint32_t count);
  void reflect(std::uint32_t i, const Vec3& n);
  void go_on(std::uint32_t count);

  float choice_[kLanes], roulette_[kLanes];
  float random_[2][kLanes];
  DirectLanes direct_;
  Vec3Lanes out_;                    // directions of the next rays
  Vec3Lanes reflected_;              // throughput before Russian roulette
  float squeeze_[kLanes];            // compression by refraction
  float kept_[kLanes];               // share of the radiance that goes on, but for colour; 0 to the wrong side
};

}  // namespace photond
