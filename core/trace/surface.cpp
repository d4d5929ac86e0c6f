#include "core/trace/surface.h"

#include <cmath>

#include "core/math/transform.h"
#include "core/scene/texture.h"
#include "core/trace/tangent_space.h"

namespace photond {

namespace {

// A texture that bends normals, if it is used, and how much.
struct NormalTexture {
  const TextureSlot& slot;
  float scale;
};

NormalTexture normal_texture(const Material& m) { return {m.normal_texture, m.normal_scale}; }
NormalTexture clearcoat_normal_texture(const Material& m) { return {m.clearcoat_normal_texture, m.clearcoat_normal_scale}; }

// `n` is the unit interpolated normal of the front face.
Vec3 apply_normal_texture(const Scene& scene, const SurfacePoint& s, const NormalTexture& texture, const Vec3& n) {
  const auto space = tangent_space(scene, s, texture.slot, n);
  if (!space) return n;
  const Vec4 texel = lookup(scene, texture.slot, s);
  const float scale = texture.scale;
  const Vec3 local{(2 * texel.x - 1) * scale, (2 * texel.y - 1) * scale, 2 * texel.z - 1};
  const Vec3 bent = local.x * space->tangent + local.y * space->bitangent + local.z * n;
  const float bent_length = glm::length(bent);
  return bent_length > 0 ? bent / bent_length : n;
}

// Shading normal on the front side: interpolated, then bent by the texture.
Vec3 front_shading_normal(const Scene& scene, const SurfacePoint& s, const NormalTexture& texture, const Vec3& front_ng) {
  Vec3 n = front_ng;
  if (!s.mesh->normals.empty()) {
    const auto& vertices = s.mesh->vertices;
    const Vec3 interpolated = (1 - s.u - s.v) * vertices[s.vertices.x].normal + s.u * vertices[s.vertices.y].normal +
                              s.v * vertices[s.vertices.z].normal;
    const Instance& placed = scene.instances[s.instance];
    n = placed.moved ? transform_normal(placed.to_world, interpolated) : interpolated;
    const float length = glm::length(n);
    n = length > 0 && is_finite(n) ? n / length : front_ng;
  }
  if (texture.slot.used()) n = apply_normal_texture(scene, s, texture, n);
  return n;
}

// Shading normal on the side of `ng`, for a ray from `wo`.
Vec3 textured_normal(const Scene& scene, const SurfacePoint& s, const NormalTexture& texture, const Vec3& wo) {
  const Vec3 front = front_shading_normal(scene, s, texture, s.front ? s.ng : -s.ng);
  return shading_normal(s.front ? front : -front, s.ng, wo);
}

TriangleVertices vertices_of(const Scene& scene, std::uint32_t instance, std::uint32_t triangle) {
  const Instance& placed = scene.instances[instance];
  const Mesh& mesh = scene.meshes[placed.mesh];
  const glm::uvec3 i = mesh.triangles[triangle];
  const Vec3& a = mesh.vertices[i.x].position;
  const Vec3& b = mesh.vertices[i.y].position;
  const Vec3& c = mesh.vertices[i.z].position;
  if (!kAllFeatures || !placed.moved) return {a, b, c};
  const Affine& m = placed.to_world;
  const float moved = std::max(max_abs(m[3]), std::numeric_limits<float>::min());   // turned about the origin, too
  TriangleVertices world{transform_point(m, a), transform_point(m, b), transform_point(m, c), is_mirrored(m), moved};
  if (world.mirrored) std::swap(world.b, world.c);
  return world;
}

}  // namespace

TriangleVertices triangle_vertices(const Scene& scene, std::uint32_t instance, std::uint32_t triangle) {
  return vertices_of(scene, instance, triangle);
}

SurfacePoint seen_from(const Scene& scene, const SurfacePoint& surface, const Vec3& wo) {
  SurfacePoint seen = surface;
  if (glm::dot(wo, surface.ng) < 0) {
    seen.front = !surface.front;
    seen.ng = -surface.ng;
  }
  seen.ns = seen.ng;
  if (seen.smooth) seen.ns = textured_normal(scene, seen, normal_texture(*seen.material), wo);
  return seen;
}

std::optional<Vec3> anisotropy_direction(const Scene& scene, const SurfacePoint& surface, const Vec2& local) {
  const Material& material = *surface.material;
  const TextureSlot& slot = material.normal_texture.used() ? material.normal_texture : material.anisotropy_texture;
  const auto space = tangent_space(scene, surface, slot, surface.front ? surface.ns : -surface.ns);
  if (!space || local == Vec2(0)) return {};
  return local.x * space->tangent + local.y * space->bitangent;
}

Vec3 clearcoat_normal(const Scene& scene, const SurfacePoint& surface, const Vec3& wo) {
  const Material& material = *surface.material;
  return material.bends_normals() ? textured_normal(scene, surface, clearcoat_normal_texture(material), wo) : surface.ns;
}

SurfacePoint make_surface(const Scene& scene, const Ray& ray, const Hit& hit) {
  SurfacePoint s;
  s.instance = hit.instance;
  s.triangle = hit.triangle;
  s.u = hit.u;
  s.v = hit.v;
  s.mesh = &scene.meshes[scene.instances[hit.instance].mesh];
  s.material = &scene.materials[s.mesh->material];
  s.ior = s.material->ior;
  s.vertices = s.mesh->triangles[hit.triangle];

  const TriangleVertices world = vertices_of(scene, hit.instance, hit.triangle);
  const float b = world.mirrored ? hit.v : hit.u;
  const float c = world.mirrored ? hit.u : hit.v;
  const FlatPoint flat = flat_point(world.a, world.b, world.c, b, c, ray.direction);
  s.position = flat.position;
  s.extent = world.moved > 0 ? world.extent() : flat.extent;
  s.front = flat.side > 0;
  s.ng = s.ns = flat.ng;
  s.smooth = kAllFeatures && (!s.mesh->normals.empty() || s.material->bends_normals());
  if (s.smooth) s.ns = textured_normal(scene, s, normal_texture(*s.material), -ray.direction);
  return s;
}

void SurfaceLanes::compute(std::uint32_t count) {
  const std::uint32_t end = whole_vectors(count);
  for (std::uint32_t i = 0; i < end; ++i) {
    const Vec3 in = direction[i];
    const FlatPoint p = at.point(i, in);
    const Vec3 n = (1 - at.u[i] - at.v[i]) * na[i] + at.u[i] * nb[i] + at.v[i] * nc[i];
    position.set(i, p.position);
    extent[i] = p.extent;
    side[i] = p.side;
    ng.set(i, p.ng);
    ns.set(i, shading_normal(p.side * n, p.ng, -in));
  }
}

SurfacePoint SurfaceLanes::point(std::uint32_t k, const Scene& scene, const Hit& hit) const {
  SurfacePoint s;
  s.position = position[k];
  s.ng = ng[k];
  s.ns = ns[k];
  s.extent = extent[k];
  s.u = hit.u;
  s.v = hit.v;
  s.instance = hit.instance;
  s.triangle = hit.triangle;
  s.mesh = &scene.meshes[scene.instances[hit.instance].mesh];
  s.material = &scene.materials[s.mesh->material];
  s.ior = s.material->ior;
  s.vertices = s.mesh->triangles[hit.triangle];
  s.front = side[k] > 0;
  s.smooth = !s.mesh->normals.empty();
  return s;
}

Vec4 lookup(const Scene& scene, const TextureSlot& slot, const SurfacePoint& surface) {
  return lookup(scene, slot, *surface.mesh, surface.vertices, surface.u, surface.v);
}

Rgb emitted_radiance(const Scene& scene, const SurfacePoint& surface) {
  const Material& material = *surface.material;
  if (!material.emissive() || !(surface.front || material.double_sided)) return Rgb(0);
  if (!material.emission_texture.used()) return material.emission;
  return material.emission * Rgb(lookup(scene, material.emission_texture, surface));
}

}  // namespace photond
