#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/math/lanes.h"
#include "core/scene/scene.h"
#include "core/trace/accel.h"
#include "core/trace/flat_point.h"
#include "core/trace/placed_mesh.h"

namespace photond {

/// A point on a surface with what shading needs; made from a hit, valid while its scene lives.
struct SurfacePoint {
  Vec3 position;
  Vec3 ng;                    ///< unit geometric normal on the side the ray came from
  Vec3 ns;                    ///< unit shading normal on the same side as ng
  float extent;               ///< to what the errors of a point on it along ng are in proportion: √3 times the largest
                              ///< |coordinate| of its vertices times |ng| on that axis, but not next to nothing. Where an
                              ///< instance is moved, the largest |coordinate| in the world and of the way it is moved
  float u;                    ///< barycentric, as in Hit
  float v;
  std::uint32_t instance;
  std::uint32_t triangle;
  glm::uvec3 vertices;        ///< indices into the mesh's attributes
  const Mesh* mesh;
  const Material* material;
  float ior;                  ///< the material's, at the wavelength of the ray (disperse), over that of what it lies in
                              ///< (Medium::relative_index)
  bool front = true;          ///< the ray came from the front face
  bool smooth = false;        ///< ns may differ from ng
};

/// World-space vertices of a placed triangle, wound so that their cross product is the front normal even where
/// the transform mirrors.
struct TriangleVertices {
  Vec3 a, b, c;
  bool mirrored = false;      ///< b and c are exchanged
  float moved = 0;            ///< largest |coordinate| of the way that the triangle is moved

  /// Largest |coordinate| that intersecting it computes with.
  float extent() const { return std::max(max_component(vertex_extents(a, b, c)), moved); }
};
TriangleVertices triangle_vertices(const Scene& scene, std::uint32_t instance, std::uint32_t triangle);

/// The unit shading normal for an interpolated normal of any length on the side of `ng`. The viewing direction stays
/// above its horizon, so that no lobe is evaluated from below; without an interpolated normal it is `ng`.
[[gnu::always_inline]] inline Vec3 shading_normal(const Vec3& interpolated, const Vec3& ng, const Vec3& wo) {
  constexpr float kMinCos = 1e-3f;
  const Vec3 ns = interpolated * (1 / std::sqrt(glm::dot(interpolated, interpolated)));
  const Vec3 bent = ns + std::max(kMinCos - glm::dot(ns, wo), 0.0f) * wo;
  const Vec3 unit = bent * (1 / std::sqrt(glm::dot(bent, bent)));
  // False, too, where a normal is zero or not finite.
  const float worst = std::min(glm::dot(ns, ng), glm::dot(unit, ng));
  return {worst > 0 ? unit.x : ng.x, worst > 0 ? unit.y : ng.y, worst > 0 ? unit.z : ng.z};
}

/// The surface where `ray` meets the scene. `hit` must be found.
SurfacePoint make_surface(const Scene& scene, const Ray& ray, const Hit& hit);

/// The unit shading normal of the point's clear coat on the side of `ng`, for a ray that arrives from `wo`.
Vec3 clearcoat_normal(const Scene& scene, const SurfacePoint& surface, const Vec3& wo);

/// In which direction a vector of the surface's tangent space points: world, at right angles to its shading normal, as
/// long as `local`; nothing where that is 0, or mesh and texture coordinates give no tangents.
std::optional<Vec3> anisotropy_direction(const Scene& scene, const SurfacePoint& surface, const Vec2& local);

/// The same point as it is for a ray that arrives from the direction `wo`.
SurfacePoint seen_from(const Scene& scene, const SurfacePoint& surface, const Vec3& wo);

/// Surfaces met by several rays. What is computed together are those without normal texture in meshes that are not moved
/// (PlacedMesh::in_place).
struct alignas(64) SurfaceLanes {
  // What comes in.
  TriangleLanes at;
  Vec3Lanes na, nb, nc;          ///< normals of the triangles' vertices
  Vec3Lanes direction;           ///< of the rays

  // What goes out, as in SurfacePoint.
  Vec3Lanes position, ng, ns;
  float extent[kLanes];
  float side[kLanes];            ///< as in FlatPoint

  /// Fills lane k.
  void set(std::uint32_t k, const PlacedMesh& mesh, const Hit& hit, const Vec3& in) {
    set(k, mesh, hit);
    direction.set(k, in);
  }
  /// The same without the direction.
  void set(std::uint32_t k, const PlacedMesh& mesh, const Hit& hit) {
    at.set(k, mesh, hit);
    const glm::uvec3& triangle = mesh.triangles[hit.triangle];
    na.set(k, mesh.vertices[triangle.x].normal);
    nb.set(k, mesh.vertices[triangle.y].normal);
    nc.set(k, mesh.vertices[triangle.z].normal);
  }
  /// Computes the first `count`.
  void compute(std::uint32_t count);
  /// What `make_surface` returns for `ray`, whose hit of `mesh` is that of lane k: from the lane where it was computed.
  SurfacePoint surface(std::uint32_t k, const Scene& scene, const PlacedMesh& mesh, const Ray& ray, const Hit& hit) const {
    return mesh.in_place ? point(k, scene, hit) : make_surface(scene, ray, hit);
  }
  /// Lane k, which was computed, as `make_surface` would return it.
  SurfacePoint point(std::uint32_t k, const Scene& scene, const Hit& hit) const;
};

/// A point safely off the surface on the side of `direction`, for rays that start there. The distance scales with
/// SurfacePoint::extent, by eight units in its last place.
inline Vec3 spawn_point(const Vec3& position, const Vec3& ng, float extent, const Vec3& direction) {
  // Interpolating the position errs by about three units in the last place of each axis' largest vertex coordinate, and
  // the intersection test of the next ray by as much again.
  constexpr float kUlps = 8 * 0x1p-23f;
  const float offset = std::max(kUlps * extent, std::numeric_limits<float>::min());
  return position + std::copysign(offset, glm::dot(direction, ng)) * ng;
}

/// A ray leaving the surface.
inline Ray spawn_ray(const SurfacePoint& surface, const Vec3& direction) {
  return {spawn_point(surface.position, surface.ng, surface.extent, direction), direction};
}

/// One texture slot at the surface, RGBA.
Vec4 lookup(const Scene& scene, const TextureSlot& slot, const SurfacePoint& surface);

/// Emitted radiance towards the side the ray came from (zero at the back of a single-sided emitter).
Rgb emitted_radiance(const Scene& scene, const SurfacePoint& surface);

}  // namespace photond
