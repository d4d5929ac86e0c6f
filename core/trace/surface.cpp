#include "core/trace/surface.h"

#include <cmath>

#include "core/math/transform.h"
#include "core/scene/texture.h"

namespace photond {

namespace {

template <class T>
T interpolate(const std::vector<T>& values, const glm::uvec3& i, float u, float v) {
  return (1 - u - v) * values[i.x] + u * values[i.y] + v * values[i.z];
}

// A texture that bends normals, if it is used, and how much.
struct NormalTexture {
  const TextureSlot& slot;
  float scale;
};

NormalTexture normal_texture(const Material& m) { return {m.normal_texture, m.normal_scale}; }
NormalTexture clearcoat_normal_texture(const Material& m) { return {m.clearcoat_normal_texture, m.clearcoat_normal_scale}; }

// Tangent and handedness of a normal texture: the mesh's own, or from the texture coordinates' gradient.
bool tangent_space(const Scene& scene, const SurfacePoint& s, const TextureSlot& slot, Vec3& tangent, float& handedness) {
  const Affine& m = scene.instances[s.instance].to_world;
  const float orientation = is_mirrored(m) ? -1.0f : 1.0f;
  if (!s.mesh->tangents.empty()) {
    const Vec4 t = interpolate(s.mesh->tangents, s.vertices, s.u, s.v);
    tangent = transform_vector(m, Vec3(t));
    handedness = t.w < 0 ? -orientation : orientation;
    return true;
  }
  const auto& uv = s.mesh->uv[slot.uv_set];
  if (uv.empty()) return false;
  const glm::mat2 turn(slot.uv_transform[0], slot.uv_transform[1]);   // tangents are the picture's axes
  const Vec3 e1 = transform_vector(m, s.mesh->positions[s.vertices.y] - s.mesh->positions[s.vertices.x]);
  const Vec3 e2 = transform_vector(m, s.mesh->positions[s.vertices.z] - s.mesh->positions[s.vertices.x]);
  const Vec2 d1 = turn * (uv[s.vertices.y] - uv[s.vertices.x]);
  const Vec2 d2 = turn * (uv[s.vertices.z] - uv[s.vertices.x]);
  const float determinant = d1.x * d2.y - d1.y * d2.x;
  if (determinant == 0) return false;
  tangent = (d2.y * e1 - d1.y * e2) * (determinant < 0 ? -1.0f : 1.0f);
  // glTF's v points down the image, so a texture without mirroring has a negative determinant here.
  handedness = determinant < 0 ? orientation : -orientation;
  return true;
}

// `n` is the unit interpolated normal of the front face.
Vec3 apply_normal_texture(const Scene& scene, const SurfacePoint& s, const NormalTexture& texture, const Vec3& n) {
  Vec3 tangent;
  float handedness = 1;
  if (!tangent_space(scene, s, texture.slot, tangent, handedness)) return n;
  tangent -= n * glm::dot(n, tangent);
  const float length = glm::length(tangent);
  if (!(length > 0)) return n;
  tangent /= length;
  const Vec3 bitangent = handedness * glm::cross(n, tangent);
  const Vec4 texel = lookup(scene, texture.slot, s);
  const float scale = texture.scale;
  const Vec3 local{(2 * texel.x - 1) * scale, (2 * texel.y - 1) * scale, 2 * texel.z - 1};
  const Vec3 bent = local.x * tangent + local.y * bitangent + local.z * n;
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
  TriangleVertices world{transform_point(m, a), transform_point(m, b), transform_point(m, c), is_mirrored(m), max_abs(m[3])};
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
  s.extent = std::max(flat.extent, world.moved);
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
