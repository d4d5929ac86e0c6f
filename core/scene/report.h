#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/math/types.h"
#include "core/scene/scene.h"

namespace photond {

/// What a person wants to know about a scene before rendering it; plain data.
struct SceneReport {
  struct CameraEntry {
    std::string name;
    bool orthographic = false;
    float yfov = 0;  ///< radians; 0 for orthographic cameras
    float ymag = 0;  ///< metres; 0 for perspective cameras
  };
  struct LightEntry {
    std::string name;
    LightType type = LightType::point;
    Rgb intensity{0};
  };
  struct MaterialEntry {
    std::string name;
    std::string kind;  ///< see material_kind
    bool emissive = false;
    bool textured = false;
  };

  std::uint64_t meshes = 0;
  std::uint64_t triangles_stored = 0;    ///< of all meshes, each once
  std::uint64_t triangles_placed = 0;    ///< of all instances
  std::uint64_t emissive_triangles = 0;  ///< placed triangles with an emissive material
  std::uint64_t instances = 0;
  std::uint64_t textures = 0;
  std::uint64_t texture_pixels = 0;
  Bounds3 bounds;
  Rgb environment{0};  ///< radiance from infinity
  std::vector<CameraEntry> cameras;
  std::vector<LightEntry> lights;
  std::vector<MaterialEntry> materials;
  std::vector<std::string> warnings;
};

SceneReport make_report(const Scene& scene);

/// Estimate of what the report keeps in memory.
std::uint64_t memory_bytes(const SceneReport& report);

/// One word for what a material mainly does: "glass" (smooth), "frosted glass", "thin glass" (no refraction),
/// "mirror" (smooth metal), "metal", "diffuse" (no specular layer), "glossy".
std::string material_kind(const Material& material);

/// "point", "spot" or "directional".
std::string light_type_name(LightType type);

/// "there is no camera 'x'; there are 'main', 'corner'": of many, the first.
std::string unknown_camera(const std::string& asked, const std::vector<Camera>& cameras);

}  // namespace photond
