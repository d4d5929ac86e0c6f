#include "core/trace/tangent_space.h"

#include <cmath>

#include "core/math/transform.h"

namespace photond {

namespace {

// A tangent of any length and slant, and the sign of the bitangent; 0 where there is none.
struct Slanted {
  Vec3 tangent{0};
  float handedness = 0;
};

Slanted of_mesh(const Scene& scene, const SurfacePoint& s) {
  const Affine& m = scene.instances[s.instance].to_world;
  const float orientation = is_mirrored(m) ? -1.0f : 1.0f;
  const auto& tangents = s.mesh->tangents;
  const glm::uvec3& i = s.vertices;
  const Vec4 t = (1 - s.u - s.v) * tangents[i.x] + s.u * tangents[i.y] + s.v * tangents[i.z];
  return {transform_vector(m, Vec3(t)), t.w < 0 ? -orientation : orientation};
}

Slanted of_coordinates(const Scene& scene, const SurfacePoint& s, const TextureSlot& slot) {
  const auto& uv = s.mesh->uv[slot.uv_set];
  if (uv.empty()) return {};
  const Affine& m = scene.instances[s.instance].to_world;
  const float orientation = is_mirrored(m) ? -1.0f : 1.0f;
  const glm::mat2 turn(slot.uv_transform[0], slot.uv_transform[1]);   // tangents are the picture's axes
  const Vec3 e1 = transform_vector(m, s.mesh->positions[s.vertices.y] - s.mesh->positions[s.vertices.x]);
  const Vec3 e2 = transform_vector(m, s.mesh->positions[s.vertices.z] - s.mesh->positions[s.vertices.x]);
  const Vec2 d1 = turn * (uv[s.vertices.y] - uv[s.vertices.x]);
  const Vec2 d2 = turn * (uv[s.vertices.z] - uv[s.vertices.x]);
  const float determinant = d1.x * d2.y - d1.y * d2.x;
  if (determinant == 0) return {};
  // glTF's v points down the image, so a texture without mirroring has a negative determinant here.
  return {(d2.y * e1 - d1.y * e2) * (determinant < 0 ? -1.0f : 1.0f), determinant < 0 ? orientation : -orientation};
}

}  // namespace

std::optional<TangentSpace> tangent_space(const Scene& scene, const SurfacePoint& s, const TextureSlot& slot,
                                          const Vec3& n) {
  const Slanted slanted = s.mesh->tangents.empty() ? of_coordinates(scene, s, slot) : of_mesh(scene, s);
  Vec3 tangent = slanted.tangent - n * glm::dot(n, slanted.tangent);
  const float length = glm::length(tangent);
  if (!(length > 0)) return {};
  tangent /= length;
  return TangentSpace{tangent, slanted.handedness * glm::cross(n, tangent)};
}

}  // namespace photond
