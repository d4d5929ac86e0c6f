#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "core/base/result.h"
#include "core/math/lanes.h"
#include "core/scene/scene.h"

namespace photond {

/// The nearest intersection of a ray with the scene.
struct Hit {
  float t = kInfinity;               ///< in units of the ray's direction
  float u = 0;                       ///< barycentric weight of the triangle's second vertex
  float v = 0;                       ///< of the third
  std::uint32_t triangle = 0;        ///< index into Mesh::triangles
  std::uint32_t instance = kNone;    ///< index into Scene::instances

  static constexpr std::uint32_t kNone = 0xffffffff;
  bool found() const { return instance != kNone; }
};

/// Rays side by side.
struct alignas(64) RayLanes {
  Vec3Lanes origin, direction;
  float t_max[kLanes];

  void set(std::uint32_t k, const Ray& ray) {
    origin.set(k, ray.origin);
    direction.set(k, ray.direction);
    t_max[k] = ray.t_max;
  }
  Ray ray(std::size_t k) const { return {origin[k], direction[k], t_max[k]}; }
};

/// What they meet, as in Hit.
struct alignas(64) HitLanes {
  float t[kLanes], u[kLanes], v[kLanes];
  std::uint32_t triangle[kLanes], instance[kLanes];

  Hit operator[](std::size_t k) const { return {t[k], u[k], v[k], triangle[k], instance[k]}; }
  void set(std::uint32_t k, const Hit& hit) {
    t[k] = hit.t;
    u[k] = hit.u;
    v[k] = hit.v;
    triangle[k] = hit.triangle;
    instance[k] = hit.instance;
  }
};

/// Whether rays that lie side by side go much the same way, as those from a camera do: no matter of results.
enum class Coherence : std::uint8_t { none, high };

/// The intersection accelerator: FewTriangles, and an Embree scene in robust mode. Meshes placed several times are built
/// once and instanced; meshes placed once with the identity transform lie directly in the top level.
class Accel {
 public:
  Accel();
  ~Accel();
  Accel(Accel&&) noexcept;
  Accel& operator=(Accel&&) noexcept;

  /// Builds over `scene`, which must outlive the accelerator at the same address of its vectors' data. Texture
  /// lookups for alpha masks happen inside the traversal. Errors: what Embree reports (memory).
  static Result<Accel> build(const Scene& scene);
  /// The same with these instances as FewTriangles: what FewTriangles::choose gave, or some of it.
  static Result<Accel> build(const Scene& scene, std::span<const std::uint32_t> few);

  /// The nearest hit in (0, ray.t_max).
  Hit intersect(const Ray& ray) const;

  /// Whether anything lies in (0, ray.t_max).
  bool occluded(const Ray& ray) const;

  /// The same for the first `count` of several rays, in less time than one by one. The last bits of a hit may depend on
  /// which rays are side by side. `hidden` is 1 or 0.
  void intersect(const RayLanes& rays, std::uint32_t count, Coherence coherence, HitLanes& hits) const;
  void occluded(const RayLanes& rays, std::uint32_t count, std::uint8_t (&hidden)[kLanes]) const;

  std::uint64_t memory_bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The version of the Embree library in use, as "3.13.5".
std::string embree_version();

/// The Embree that runs and what it uses of this CPU: where that differs, hits may differ in their last bits.
std::string embree_target();

}  // namespace photond
