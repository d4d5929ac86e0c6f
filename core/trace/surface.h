#pragma once

#include "core/scene/scene.h"
#include "core/trace/accel.h"

namespace photond {

/// A point on a surface with what shading needs; made from a hit, valid while its scene lives.
struct SurfacePoint {
  Vec3 position;
  Vec3 ng;                    ///< unit geometric normal on the side the ray came from
  Vec3 ns;                    ///< unit shading normal on the same side as ng
  float extent;               ///< largest |coordinate| of the triangle: what floating point resolves here
  float u;                    ///< barycentric, as in Hit
  float v;
  std::uint32_t instance;
  std::uint32_t triangle;
  glm::uvec3 vertices;        ///< indices into the mesh's attributes
  const Mesh* mesh;
  const Material* material;
  bool front = true;          ///< the ray came from the front face
  bool smooth = false;        ///< ns may differ from ng
};

/// World-space vertices of a placed triangle, wound so that their cross product is the front normal even where
/// the transform mirrors.
struct TriangleVertices {
  Vec3 a, b, c;
  bool mirrored = false;      ///< b and c are exchanged
};
TriangleVertices triangle_vertices(const Scene& scene, std::uint32_t instance, std::uint32_t triangle);

/// The surface where `ray` meets the scene. `hit` must be found.
SurfacePoint make_surface(const Scene& scene, const Ray& ray, const Hit& hit);

/// Asks the cache for what make_surface will read of a hit: first the triangle's indices, then (when those have
/// arrived) its vertices. Nothing else happens; a hit not found is ignored.
void prefetch_triangle(const Scene& scene, const Hit& hit);
void prefetch_vertices(const Scene& scene, const Hit& hit);

/// A point safely off the surface on the side of `direction`, for rays that start there. The distance scales
/// with the coordinates: about eight units in the last place of the largest vertex coordinate.
Vec3 spawn_point(const Vec3& position, const Vec3& ng, float extent, const Vec3& direction);

/// A ray leaving the surface.
inline Ray spawn_ray(const SurfacePoint& surface, const Vec3& direction) {
  return {spawn_point(surface.position, surface.ng, surface.extent, direction), direction};
}

/// One texture slot at the surface, RGBA.
Vec4 lookup(const Scene& scene, const TextureSlot& slot, const SurfacePoint& surface);

/// Emitted radiance towards the side the ray came from (zero at the back of a single-sided emitter).
Rgb emitted_radiance(const Scene& scene, const SurfacePoint& surface);

}  // namespace photond
