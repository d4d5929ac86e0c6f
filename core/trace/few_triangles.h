#pragma once

#include <vector>

#include "core/scene/scene.h"
#include "core/trace/accel.h"

namespace photond {

/// A few triangles, as of walls, which rays that lie side by side try one after the other: quicker than any tree. No ray
/// slips through where triangles meet at edges or corners.
class FewTriangles {
 public:
  /// Instances that lie in the world as their mesh does, of few triangles and opaque: the largest, as many as pay. None
  /// where too many rays would cross what covers the others anyway.
  static std::vector<std::uint32_t> choose(const Scene& scene);

  FewTriangles() = default;
  FewTriangles(const Scene& scene, std::span<const std::uint32_t> instances);

  bool empty() const { return triangles_.empty(); }

  /// As Accel.
  void intersect(const RayLanes& rays, std::uint32_t count, HitLanes& hits) const;
  void occluded(const RayLanes& rays, std::uint32_t count, std::uint8_t (&hidden)[kLanes]) const;

 private:
  struct Edge {
    std::uint32_t from, to;            // vertices, the lower one first
  };
  struct Plane {
    Vec3 point, normal;
  };
  // An edge as a triangle's outline runs along it.
  struct Side {
    std::uint32_t edge = 0;
    std::uint32_t reversed = 0;        // its sign bit where it runs from `to` to `from`
  };
  struct Triangle {
    Side sides[3];                     // opposite to each vertex
    std::uint32_t plane, instance, index;
  };
  struct Passing;
  struct Meeting;

  void add(const Scene& scene, std::uint32_t instance, std::uint32_t index);
  std::uint32_t vertex(const Vec3& position);
  Side side(std::uint32_t from, std::uint32_t to);
  std::uint32_t plane(const Plane& plane);

  std::vector<Vec3> vertices_;
  std::vector<Edge> edges_;
  std::vector<Plane> planes_;
  std::vector<Triangle> triangles_;
};

}  // namespace photond
