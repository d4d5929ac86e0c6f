#include "core/scene/report.h"

#include <algorithm>

namespace photond {
namespace {

// Of a name in a sentence for a person; whole characters of UTF-8.
std::string beginning(const std::string& name) {
  constexpr std::size_t kMostBytes = 60;
  std::size_t end = std::min(name.size(), kMostBytes);
  while (end > 0 && end < name.size() && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;
  return name.substr(0, end);
}

bool is_textured(const Material& m) {
  return std::ranges::any_of(texture_slots(m), [](const TextureSlot* slot) { return slot->used(); });
}

void count_geometry(const Scene& scene, SceneReport& report) {
  report.meshes = scene.meshes.size();
  report.instances = scene.instances.size();
  for (const Mesh& mesh : scene.meshes) report.triangles_stored += mesh.triangles.size();
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    report.triangles_placed += mesh.triangles.size();
    if (scene.materials[mesh.material].emissive()) report.emissive_triangles += mesh.triangles.size();
  }
}

template <class Entry>
std::uint64_t bytes_of(const std::vector<Entry>& entries) {
  std::uint64_t bytes = entries.capacity() * sizeof(Entry);
  for (const Entry& entry : entries) bytes += entry.name.capacity();
  return bytes;
}

}  // namespace

SceneReport make_report(const Scene& scene) {
  SceneReport report;
  count_geometry(scene, report);
  report.textures = scene.textures.size();
  for (const TextureImage& image : scene.images) {
    report.texture_pixels += static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height);
  }
  report.bounds = world_bounds(scene);
  report.bounds.min += scene.origin;
  report.bounds.max += scene.origin;
  report.environment = scene.environment.radiance;
  for (const Camera& camera : scene.cameras) {
    report.cameras.push_back({camera.name, camera.orthographic, camera.orthographic ? 0 : camera.yfov,
                              camera.orthographic ? camera.ymag : 0});
  }
  for (const PunctualLight& light : scene.lights) {
    report.lights.push_back({light.name, light.type, light.intensity});
  }
  for (const Material& material : scene.materials) {
    report.materials.push_back(
        {material.name, material_kind(material), material.emissive(), is_textured(material)});
  }
  report.warnings = scene.warnings;
  return report;
}

std::uint64_t memory_bytes(const SceneReport& report) {
  std::uint64_t bytes = sizeof report + bytes_of(report.cameras) + bytes_of(report.lights) + bytes_of(report.materials);
  for (const std::string& warning : report.warnings) bytes += sizeof warning + warning.capacity();
  return bytes;
}

std::string material_kind(const Material& m) {
  const bool smooth = m.roughness == 0 && m.anisotropy == 0;
  if (m.transmission > 0.5f && m.metallic < 0.5f) {
    if (m.thin_walled) return "thin glass";
    return smooth ? "glass" : "frosted glass";
  }
  if (m.metallic >= 0.5f) return smooth ? "mirror" : "metal";
  return m.specular == 0 || is_black(m.specular_color) ? "diffuse" : "glossy";
}

std::string light_type_name(LightType type) {
  if (type == LightType::point) return "point";
  return type == LightType::spot ? "spot" : "directional";
}

std::string unknown_camera(const std::string& asked, const std::vector<Camera>& cameras) {
  constexpr std::size_t kMostNames = 8;
  std::string known;
  for (std::size_t i = 0; i < std::min(cameras.size(), kMostNames); ++i)
    known += (known.empty() ? "'" : ", '") + beginning(cameras[i].name) + "'";
  if (cameras.size() > kMostNames) known += " and " + std::to_string(cameras.size() - kMostNames) + " more";
  return "there is no camera '" + beginning(asked) + "'; there are " + known;
}

}  // namespace photond
