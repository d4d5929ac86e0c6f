#include "core/trace/placed_mesh.h"

namespace photond {

namespace {

// The material has the one lobe of a Lambert surface, as Bsdf finds it, and no texture to scale it. A colour that is
// not finite is left to where photons are rejected.
bool is_lambert(const Material& m) {
  return m.metallic == 0 && m.specular == 0 && m.transmission == 0 && !is_black(m.base_color) &&
         is_finite(m.base_color) && !m.base_color_texture.used() && !m.normal_texture.used();
}

bool is_plain(const Scene& scene, const Instance& instance) {
  const Mesh& mesh = scene.meshes[instance.mesh];
  return !instance.moved && mesh.normals.empty() && mesh.colors.empty() && is_lambert(scene.materials[mesh.material]);
}

}  // namespace

std::vector<PlacedMesh> placed_meshes(const Scene& scene) {
  static constexpr glm::uvec3 kTriangle{0, 0, 0};
  static constexpr Vertex kVertex{};
  std::vector<PlacedMesh> placed;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    const Material& material = scene.materials[mesh.material];
    placed.push_back({mesh.triangles.data(), mesh.vertices.data(), material.base_color, is_plain(scene, instance),
                      material.emissive(), !instance.moved && !material.normal_texture.used()});
  }
  placed.push_back({&kTriangle, &kVertex});
  return placed;
}

}  // namespace photond
