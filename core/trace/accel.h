#pragma once

#include <cstdint>
#include <memory>

#include "core/base/result.h"
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

/// The intersection accelerator: one Embree scene in robust mode. Meshes placed several times are built once and
/// instanced; meshes placed once with the identity transform lie directly in the top level.
class Accel {
 public:
  Accel();
  ~Accel();
  Accel(Accel&&) noexcept;
  Accel& operator=(Accel&&) noexcept;

  /// Builds over `scene`, which must outlive the accelerator at the same address of its vectors' data. Texture
  /// lookups for alpha masks happen inside the traversal. Errors: what Embree reports (memory).
  static Result<Accel> build(const Scene& scene);

  /// The nearest hit in (0, ray.t_max).
  Hit intersect(const Ray& ray) const;

  /// Whether anything lies in (0, ray.t_max).
  bool occluded(const Ray& ray) const;

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
