#include "server/cli/load_scene.h"

#include <algorithm>
#include <charconv>

#include "core/scene/report.h"
#include "server/cli/files.h"

namespace photond {
namespace {

constexpr std::uint64_t kMaxFileBytes = 4ull << 30;  // a GLB's length field ends there

bool is_inside(const std::filesystem::path& path, const std::filesystem::path& folder) {
  const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return end == folder.end();
}

Result<std::filesystem::path> resolve(const std::filesystem::path& folder, const std::string& resource) {
  const std::filesystem::path relative(resource);
  const bool climbs = std::find(relative.begin(), relative.end(), "..") != relative.end();
  if (resource.empty() || relative.is_absolute() || climbs || resource.find('\0') != std::string::npos) {
    return invalid_input("'" + resource + "' is not a path within the scene's folder");
  }
  std::error_code failure;
  const auto root = std::filesystem::canonical(folder, failure);
  if (failure) return Error{ErrorCode::io, failure.message(), folder.string()};
  // Links are followed before the comparison, so one that leads outside is caught.
  const auto path = std::filesystem::canonical(root / relative, failure);
  if (failure) return Error{ErrorCode::not_found, "'" + resource + "' does not exist in the scene's folder", {}};
  if (!is_inside(path, root)) return invalid_input("'" + resource + "' leads outside the scene's folder");
  return path;
}

}  // namespace

ResourceReader folder_resources(const std::filesystem::path& folder) {
  return [folder](const std::string& resource) -> Result<std::vector<std::byte>> {
    const auto path = resolve(folder, resource);
    if (!path) return path.error();
    auto bytes = read_file(*path, kMaxFileBytes);
    if (!bytes) return Error{bytes.error().code, "'" + resource + "': " + bytes.error().message, {}};
    return bytes;
  };
}

Result<Scene> load_scene(const std::filesystem::path& file) {
  const auto bytes = read_file(file, kMaxFileBytes);
  if (!bytes) return bytes.error();
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  return read_gltf(*bytes, folder_resources(folder));
}

Result<Scene> load_scene(const std::filesystem::path& file, const EnvironmentOptions& environment) {
  auto scene = load_scene(file);
  if (!scene || environment.file.empty()) return scene;
  const auto bytes = read_file(environment.file, kMaxFileBytes);
  if (!bytes) return Error{bytes.error().code, bytes.error().message, environment.file};
  auto map = read_environment(*bytes);
  if (!map) return Error{map.error().code, map.error().message, environment.file};
  set_environment(*scene, {.radiance = Rgb(environment.scale),
                           .map = *std::move(map),
                           .rotation = glm::radians(environment.rotation_deg)});
  return scene;
}

Result<Camera> find_camera(const Scene& scene, const std::string& text) {
  if (text.empty()) return scene.cameras.front();
  for (const Camera& camera : scene.cameras) {
    if (camera.name == text) return camera;
  }
  std::size_t index = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), index);
  if (failure == std::errc{} && end == text.data() + text.size() && index < scene.cameras.size()) {
    return scene.cameras[index];
  }
  return Error{ErrorCode::not_found, unknown_camera(text, scene.cameras), {}};
}

}  // namespace photond
