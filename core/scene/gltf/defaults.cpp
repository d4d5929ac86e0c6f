// What a file leaves open, and what photond leaves out.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "core/scene/gltf/build.h"
#include "core/scene/gltf/check.h"
#include "core/scene/gltf/extensions.h"

namespace photond::gltf {
namespace {

// Whether a surface is meant to light others. A texture that glows no brighter than paper (a label, a display) is
// not: its file was made to be seen in somebody else's light.
bool has_emitter(const Scene& scene) {
  const auto shines = [&](const Instance& instance) {
    const Material& m = scene.materials[scene.meshes[instance.mesh].material];
    return m.emissive() && (!m.emission_texture.used() || max_component(m.emission) > 1);
  };
  return std::any_of(scene.instances.begin(), scene.instances.end(), shines);
}

bool has_light(const Scene& scene) {
  const auto shines = [](const PunctualLight& light) { return !is_black(light.intensity); };
  return std::any_of(scene.lights.begin(), scene.lights.end(), shines);
}

/// From front, right and above, far enough that the bounding sphere fits into the view.
Camera framing_camera(const Bounds3& bounds) {
  constexpr float kYfov = 0.7f;
  const Vec3 from_center = glm::normalize(Vec3(0.55f, 0.4f, 1.0f));
  const float radius = std::max(bounds.radius(), 1e-6f);
  const float distance = 1.05f * radius / std::sin(0.5f * kYfov);
  Camera camera = look_at(bounds.center() + distance * from_center, bounds.center(), Vec3(0, 1, 0), kYfov);
  camera.name = "default";
  return camera;
}

/// Warns of all extensions of one object that are not read, and remembers their names.
void warn_of_extensions(Build& build, const tinygltf::ExtensionMap& extensions, const std::string& where,
                        std::set<std::string>& seen) {
  for (const auto& [name, value] : extensions) {
    if (is_supported_extension(name)) continue;
    seen.insert(name);
    build.warnings.add(name.substr(0, 80) + " ignored", where);
  }
}

}  // namespace

void add_defaults(Build& build) {
  Scene& scene = build.scene;
  if (scene.cameras.empty()) {
    scene.cameras.push_back(framing_camera(world_bounds(scene)));
    build.warnings.add("the file has no camera: a default camera frames the scene", "cameras");
  }
  if (!has_light(scene) && !has_emitter(scene)) {
    scene.environment.radiance = Rgb(1);
    build.warnings.add(kNoLightWarning, "lights");
  }
}

void warn_of_far_scene(Build& build) {
  // A ten-thousandth of the scene's size: a tenth of a pixel in a picture of a thousand.
  static constexpr float kCoarse = 1e-4f;
  const Bounds3 bounds = world_bounds(build.scene);
  if (bounds.empty()) return;
  const float rounding = 0x1p-23f * std::max(max_component(glm::abs(bounds.min)), max_component(glm::abs(bounds.max)));
  if (!(rounding > kCoarse * bounds.radius())) return;
  char text[128];
  std::snprintf(text, sizeof text, "the scene lies far from the origin: positions are rounded to %.2g m, and it is %.2g m large",
                static_cast<double>(rounding), static_cast<double>(2 * bounds.radius()));
  build.warnings.add(text, "nodes");
}

void warn_of_ignored(Build& build) {
  const tinygltf::Model& model = build.model;
  std::set<std::string> seen;
  for (std::size_t i = 0; i < model.materials.size(); ++i) {
    warn_of_extensions(build, model.materials[i].extensions, place("materials", i), seen);
    if (model.materials[i].occlusionTexture.index >= 0) {
      build.warnings.add("occlusion texture ignored: occlusion is computed", place("materials", i));
    }
  }
  for (std::size_t i = 0; i < model.textures.size(); ++i) {
    warn_of_extensions(build, model.textures[i].extensions, place("textures", i), seen);
  }
  for (std::size_t m = 0; m < model.meshes.size(); ++m) {
    for (std::size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
      const std::string where = place("meshes", m) + "." + place("primitives", p);
      warn_of_extensions(build, model.meshes[m].primitives[p].extensions, where, seen);
    }
  }
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    warn_of_extensions(build, model.nodes[i].extensions, place("nodes", i), seen);
  }
  warn_of_extensions(build, model.extensions, "extensions", seen);
  for (std::size_t i = 0; i < model.extensionsUsed.size(); ++i) {
    const std::string& name = model.extensionsUsed[i];
    if (is_supported_extension(name) || seen.contains(name)) continue;
    build.warnings.add(name.substr(0, 80) + " ignored", place("extensionsUsed", i));
  }
  for (std::size_t i = 0; i < model.lights.size(); ++i) {
    if (model.lights[i].range > 0)
      build.warnings.add("range ignored: light reaches any distance",
                         "extensions.KHR_lights_punctual." + place("lights", i));
  }
  if (build.degenerate > 0) {
    build.warnings.add(std::to_string(build.degenerate) + " degenerate triangles dropped, the first here",
                       build.first_degenerate);
  }
  if (!model.animations.empty())
    build.warnings.add("animation ignored: the scene stands as modelled", "animations");
}

}  // namespace photond::gltf
