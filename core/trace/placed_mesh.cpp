#include "core/trace/placed_mesh.h"

#include "core/trace/microfacet.h"

namespace photond {

namespace {

// As Bsdf finds the lobes. A colour that is not finite is left to where photons are rejected.
Shading shading_of(const Material& m) {
  if (!is_finite(m.base_color) || m.base_color_texture.used() || m.bends_normals()) return Shading::other;
  // On blended surfaces photons count for more (Shooter::as_stored).
  if (m.bare_diffuse()) return m.alpha_mode == AlphaMode::blend ? Shading::other : Shading::diffuse;
  if (m.anisotropy > 0 || m.clearcoat > 0 || m.sheened()) return Shading::other;
  if (!(m.roughness * m.roughness < kSmoothAlpha) || m.metallic_roughness_texture.used()) return Shading::other;
  if (m.metallic == 1 && !is_black(m.base_color)) return Shading::mirror;
  const bool textured = m.specular_texture.used() || m.specular_color_texture.used() || m.transmission_texture.used();
  const bool by_fresnel = m.transmission == 1 && m.specular == 1 && m.specular_color == Rgb(1) && !textured;
  const bool clear = !m.thin_walled && m.ior != 0 && m.dispersion == 0 && !m.nested && !(m.attenuation_distance < kInfinity);
  return m.metallic == 0 && by_fresnel && clear ? Shading::glass : Shading::other;
}

Shading shading_of(const Scene& scene, const Instance& instance) {
  const Mesh& mesh = scene.meshes[instance.mesh];
  if (instance.moved || !mesh.colors.empty()) return Shading::other;
  return shading_of(scene.materials[mesh.material]);
}

}  // namespace

std::vector<PlacedMesh> placed_meshes(const Scene& scene) {
  static constexpr glm::uvec3 kTriangle{0, 0, 0};
  static constexpr Vertex kVertex{};
  std::vector<PlacedMesh> placed;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    const Material& material = scene.materials[mesh.material];
    const Shading shading = shading_of(scene, instance);
    const bool plain = shading == Shading::diffuse && mesh.normals.empty() && !is_black(material.base_color);
    const bool in_place = !instance.moved && !material.bends_normals();
    placed.push_back({mesh.triangles.data(), mesh.vertices.data(), material.base_color, plain, material.emissive(),
                      in_place, shading, material.ior});
  }
  placed.push_back({&kTriangle, &kVertex});
  return placed;
}

}  // namespace photond
