#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/math/lanes.h"
#include "core/trace/accel.h"
#include "core/trace/placed_mesh.h"

namespace photond {

/// What the triangle alone says of a point on it.
struct FlatPoint {
  Vec3 position;
  Vec3 ng;                    ///< unit geometric normal on the side the ray came from
  float extent;               ///< as SurfacePoint::extent
  float side;                 ///< 1 where the ray came from the front, else −1
};

inline float max_abs(const Vec3& v) { return max_component(glm::abs(v)); }

/// Largest |coordinates| of a triangle.
[[gnu::always_inline]] inline Vec3 vertex_extents(const Vec3& a, const Vec3& b, const Vec3& c) {
  return glm::max(glm::max(glm::abs(a), glm::abs(b)), glm::abs(c));
}

/// Unit normal of a triangle with edges ab, ac, whatever their length; z where the triangle is degenerate.
[[gnu::always_inline]] inline Vec3 unit_normal(const Vec3& ab, const Vec3& ac) {
  // Scaled to about 1: the squares would underflow for triangles of a micrometre.
  const float scale = 1 / std::max(std::max(max_abs(ab), max_abs(ac)), std::numeric_limits<float>::min());
  const Vec3 n = glm::cross(ab * scale, ac * scale);
  const float length_sq = glm::dot(n, n);
  const float inverse = 1 / std::sqrt(length_sq);
  return length_sq > 0 ? n * inverse : Vec3(0, 0, 1);
}

/// The point a + u·ab + v·ac of a triangle met from `direction`.
[[gnu::always_inline]] inline FlatPoint flat_point(const Vec3& a, const Vec3& b, const Vec3& c, float u, float v,
                                                   const Vec3& direction) {
  FlatPoint p;
  p.position = (1 - u - v) * a + u * b + v * c;
  const Vec3 normal = unit_normal(b - a, c - a);
  // Products and maxima are the same in lanes and alone; a sum would not be. Of what lies at 0 a little: numbers that are
  // not normal take a hundred times as long.
  const Vec3 extents = vertex_extents(a, b, c);
  constexpr float kLeast = 0x1p-10f;
  p.extent = std::max(std::numbers::sqrt3_v<float> * max_component(glm::abs(normal) * extents),
                      kLeast * max_component(extents));
  p.side = std::copysign(1.0f, -glm::dot(normal, direction));  // from which side a ray comes no branch can predict
  p.ng = p.side * normal;
  return p;
}

/// Points on several triangles of meshes that are not moved.
struct alignas(64) TriangleLanes {
  Vec3Lanes a, b, c;
  float u[kLanes], v[kLanes];   ///< as in Hit

  /// Fills lane k.
  void set(std::uint32_t k, const PlacedMesh& mesh, const Hit& hit) {
    const glm::uvec3& triangle = mesh.triangles[hit.triangle];
    a.set(k, mesh.vertices[triangle.x].position);
    b.set(k, mesh.vertices[triangle.y].position);
    c.set(k, mesh.vertices[triangle.z].position);
    u[k] = hit.u;
    v[k] = hit.v;
  }
  /// Lane i, met from `direction`.
  [[gnu::always_inline]] FlatPoint point(std::uint32_t i, const Vec3& direction) const {
    return flat_point(a[i], b[i], c[i], u[i], v[i], direction);
  }
};

}  // namespace photond
