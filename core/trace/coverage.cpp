#include "core/trace/coverage.h"

#include <algorithm>

#include "core/scene/texture.h"

namespace photond {

namespace {

float alpha_at(const Scene& scene, const Mesh& mesh, const Material& material, std::uint32_t primitive, float u,
               float v) {
  const glm::uvec3 triangle = mesh.triangles[primitive];
  float value = material.alpha;
  if (!mesh.colors.empty()) {
    value *= (1 - u - v) * mesh.colors[triangle.x].w + u * mesh.colors[triangle.y].w + v * mesh.colors[triangle.z].w;
  }
  const TextureSlot& slot = material.base_color_texture;
  if (slot.used()) value *= lookup(scene, slot, mesh, triangle, u, v).w;
  return value;
}

}  // namespace

float coverage(const Scene& scene, const Mesh& mesh, std::uint32_t triangle, float u, float v) {
  const Material& material = scene.materials[mesh.material];
  if (material.alpha_mode == AlphaMode::opaque) return 1;
  const float alpha = alpha_at(scene, mesh, material, triangle, u, v);
  // glTF: a mask shows where alpha ≥ cutoff.
  if (material.alpha_mode == AlphaMode::mask) return alpha >= material.alpha_cutoff ? 1 : 0;
  return std::clamp(alpha, 0.0f, 1.0f);
}

}  // namespace photond
