#include "core/scene/gltf/extensions.h"

#include <algorithm>
#include <array>

namespace photond::gltf {
namespace {

constexpr std::array<std::string_view, 18> kSupported = {
    "EXT_mesh_gpu_instancing",         "EXT_meshopt_compression", "EXT_texture_webp",
    "KHR_draco_mesh_compression",      "KHR_lights_punctual",     "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",         "KHR_materials_dispersion",
    "KHR_materials_emissive_strength", "KHR_materials_ior",       "KHR_materials_sheen",
    "KHR_materials_specular",          "KHR_materials_transmission",
    "KHR_materials_unlit",             "KHR_materials_volume",    "KHR_mesh_quantization",
    "KHR_texture_transform",           "KHR_xmp_json_ld"};

}  // namespace

bool is_supported_extension(std::string_view name) {
  return std::find(kSupported.begin(), kSupported.end(), name) != kSupported.end();
}

Status check_required_extensions(const std::vector<std::string>& required) {
  for (std::size_t i = 0; i < required.size(); ++i) {
    if (is_supported_extension(required[i])) continue;
    return Error{ErrorCode::unsupported,
                 "the file requires " + required[i].substr(0, 80) + ", which is not supported",
                 "extensionsRequired[" + std::to_string(i) + "]"};
  }
  return Done{};
}

}  // namespace photond::gltf
