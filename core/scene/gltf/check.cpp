#include "core/scene/gltf/check.h"

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

namespace photond::gltf {
namespace {

/// Major and minor of "2.0"; {0, 0} where the text is not such.
std::array<int, 2> parse_version(const std::string& text) {
  std::array<int, 2> version{0, 0};
  const char* end = text.data() + text.size();
  const auto major = std::from_chars(text.data(), end, version[0]);
  if (major.ec != std::errc() || major.ptr == end || *major.ptr != '.') return {0, 0};
  const auto minor = std::from_chars(major.ptr + 1, end, version[1]);
  return minor.ec == std::errc() && minor.ptr == end ? version : std::array<int, 2>{0, 0};
}

Status check_asset(const tinygltf::Asset& asset) {
  if (parse_version(asset.version)[0] != 2) {
    return Error{ErrorCode::unsupported, "glTF version must be 2.x", "asset.version"};
  }
  if (asset.minVersion.empty()) return Done{};
  const auto minimum = parse_version(asset.minVersion);
  if (minimum[0] != 2 || minimum[1] > 0) {
    return Error{ErrorCode::unsupported, "the file needs a glTF version newer than 2.0", "asset.minVersion"};
  }
  return Done{};
}

}  // namespace

std::string place(std::string_view array, std::size_t index) {
  return std::string(array) + "[" + std::to_string(index) + "]";
}

Status check_index(int index, std::size_t size, const std::string& where, bool optional) {
  if (optional && index == -1) return Done{};
  if (index >= 0 && static_cast<std::size_t>(index) < size) return Done{};
  return invalid_input(
      "index " + std::to_string(index) + " does not exist (there are " + std::to_string(size) + ")", where);
}

Status check_cameras(const tinygltf::Model& model) {
  for (std::size_t i = 0; i < model.cameras.size(); ++i) {
    const tinygltf::Camera& camera = model.cameras[i];
    const std::string where = place("cameras", i);
    const auto& perspective = camera.perspective;
    if (camera.type == "perspective") {
      if (!(perspective.yfov > 0 && perspective.yfov < std::numbers::pi)) {
        return invalid_input("yfov must be between 0 and pi", where + ".perspective.yfov");
      }
      if (!(perspective.znear > 0)) {
        return invalid_input("znear must be positive", where + ".perspective.znear");
      }
    } else if (camera.orthographic.xmag == 0 || camera.orthographic.ymag == 0) {
      return invalid_input("magnification must not be 0", where + ".orthographic");
    }
  }
  return Done{};
}

Status check_lights(const tinygltf::Model& model) {
  for (std::size_t i = 0; i < model.lights.size(); ++i) {
    const tinygltf::Light& light = model.lights[i];
    const std::string where = "extensions.KHR_lights_punctual." + place("lights", i);
    if (light.type != "point" && light.type != "spot" && light.type != "directional") {
      return invalid_input("light type \"" + light.type.substr(0, 40) + "\" is unknown", where + ".type");
    }
    const auto& spot = light.spot;
    // glTF wants inner < outer, but exporters write equal ones for a spot with a hard edge.
    const bool cone =
        spot.innerConeAngle <= spot.outerConeAngle && spot.outerConeAngle > 0 && spot.outerConeAngle <= 1.5707964;
    if (light.type == "spot" && !cone) {
      return invalid_input("cone angles must satisfy inner <= outer <= pi/2, and outer > 0", where + ".spot");
    }
  }
  return Done{};
}

Status check_model(const tinygltf::Model& model, const SceneLimits& limits) {
  if (Status status = check_asset(model.asset); !status) return status;
  if (Status status = check_buffer_views(model); !status) return status;
  if (Status status = check_accessors(model, limits); !status) return status;
  if (Status status = check_textures(model); !status) return status;
  if (Status status = check_meshes(model); !status) return status;
  if (Status status = check_cameras(model); !status) return status;
  if (Status status = check_lights(model); !status) return status;
  if (Status status = check_nodes(model); !status) return status;
  return check_scenes(model);
}

}  // namespace photond::gltf
