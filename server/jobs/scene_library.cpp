#include "server/jobs/scene_library.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <utility>

#include "core/render/render.h"
#include "server/jobs/scene_archive.h"
#include "server/store/file.h"

namespace photond {

namespace {

Result<std::vector<std::byte>> read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return Error{ErrorCode::io, "cannot read " + path.string(), ""};
  std::vector<std::byte> bytes(static_cast<std::size_t>(file.tellg()));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file) return Error{ErrorCode::io, "cannot read " + path.string(), ""};
  return bytes;
}

/// Of glTF the bytes tell which of its two forms it is, whatever it is sent as.
std::string true_type(const std::vector<std::byte>& bytes, const std::string& media_type) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (media_type == "application/zip") return media_type;
  return text.starts_with("glTF") ? "model/gltf-binary" : "model/gltf+json";
}

Result<Scene> parse(std::span<const std::byte> bytes, const std::string& media_type) {
  if (media_type == "model/gltf-binary" || media_type == "model/gltf+json")
    return read_gltf(bytes, no_resources());
  if (media_type != "application/zip") {
    return Error{ErrorCode::unsupported, "scenes are model/gltf-binary, model/gltf+json or application/zip",
                 ""};
  }
  const Result<SceneArchive> archive = read_archive(bytes);
  if (!archive) return archive.error();
  return read_gltf(archive->root_bytes(), archive->reader());
}

/// Names a scene in an environment.
Digest key_of(const Digest& scene, const EnvironmentChoice& choice) {
  Hasher hasher;
  hasher.update_value(scene.bytes);
  hasher.update_value(choice.id.bytes);
  hasher.update_value(choice.rotation_deg);
  hasher.update_value(choice.scale);
  return hasher.finish();
}

/// Holds one of the permits for parsing; without one where the stop token came first.
class ParsePermit {
 public:
  ParsePermit(std::counting_semaphore<2>& permits, const std::stop_token& stop) : permits_(permits) {
    using namespace std::chrono_literals;
    while (!held_ && !stop.stop_requested()) held_ = permits_.try_acquire_for(50ms);
  }
  ~ParsePermit() {
    if (held_) permits_.release();
  }
  ParsePermit(const ParsePermit&) = delete;
  ParsePermit& operator=(const ParsePermit&) = delete;
  bool held() const { return held_; }

 private:
  std::counting_semaphore<2>& permits_;
  bool held_ = false;
};

}  // namespace

Result<std::vector<std::filesystem::path>> sample_files(const std::string& folder) {
  std::error_code failed;
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder, failed)) {
    if (entry.path().extension() == ".glb") paths.push_back(entry.path());
  }
  if (failed)
    return Error{ErrorCode::io, "cannot read the samples folder " + folder + ": " + failed.message(), ""};
  std::sort(paths.begin(), paths.end());
  return paths;
}

Status SceneLibrary::add_samples(std::span<const std::filesystem::path> files) {
  for (const auto& path : files) {
    Result<std::vector<std::byte>> bytes = read_file(path);
    if (!bytes) return bytes.error();
    SceneRecord scene{sha256(*bytes),
                      path.stem().string(),
                      "model/gltf-binary",
                      bytes->size(),
                      true,
                      std::chrono::system_clock::now()};
    if (const Status put = store_.put_scene(scene, *bytes); !put) return put;
  }
  return Done{};
}

Result<SceneLibrary::Added> SceneLibrary::add(std::vector<std::byte> bytes, const std::string& media_type,
                                              const std::string& name, const Owner& owner, std::stop_token stop) {
  const Digest id = sha256(bytes);
  if (auto known = store_.scene(id)) {
    if (!known->name.empty() || name.empty() || !owner.may_change(known->owner)) return Added{*known, false};
    if (const Status named = store_.name_scene(id, name); !named) return named.error();
    known->name = name;
    return Added{*known, false};
  }
  if (const Status room = room_.make_room(bytes.size()); !room) return room.error();
  const Blob blob = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
  const Execution execution = workers_.execution(stop);
  auto scene = prepared_.get_or_build(
      id, [&] { return prepare_bytes(blob, media_type, std::nullopt, execution); }, stop);
  if (!scene) return scene.error();
  auto described = summaries_.get_or_build(
      id, [&] { return summarize(scene->value, execution); }, stop);
  if (!described) return described.error();
  SceneRecord record{id,    name, true_type(*blob, media_type), blob->size(),
                     false, std::chrono::system_clock::now(),   owner.key};
  if (const Status put = store_.put_scene(record, *blob, owner.limits.bytes); !put) return put.error();
  return Added{record, true};
}

Result<SceneLibrary::Summary> SceneLibrary::summary(const Digest& id, std::stop_token stop) {
  // What is remembered of a scene may outlive it.
  if (!store_.scene(id)) return Error{ErrorCode::not_found, "there is no scene " + to_hex(id), "/scene"};
  const Execution execution = workers_.execution(stop);
  const auto build = [&]() -> Result<Summary> {
    const Result<Prepared> scene = prepared(id, execution);
    if (!scene) return scene.error();
    return summarize(*scene, execution);
  };
  auto answer = summaries_.get_or_build(id, build, stop);
  if (!answer) return answer.error();
  return std::move(answer->value);
}

Result<SceneLibrary::Prepared> SceneLibrary::prepared(const Digest& id, const std::optional<EnvironmentChoice>& choice,
                                                      const Execution& execution) {
  const auto record = store_.scene(id);
  if (!record) return Error{ErrorCode::not_found, "there is no scene " + to_hex(id), "/scene"};
  std::optional<Environment> environment;
  if (choice) {
    Result<Environment> found = environments_.environment(*choice, execution.stop);
    if (!found) return found.error();
    environment = std::move(*found);
  }
  const auto build = [&]() -> Result<Prepared> {
    const Result<Blob> bytes = store_.scene_bytes(id);
    if (!bytes) return bytes.error();
    return prepare_bytes(*bytes, record->media_type, environment, execution);
  };
  auto answer = prepared_.get_or_build(choice ? key_of(id, *choice) : id, build, execution.stop);
  if (!answer && is_disk_unreachable(answer.error())) return answer.error();
  if (!answer) return Error{answer.error().code, answer.error().message, "/scene"};
  return std::move(answer->value);
}

Result<SceneLibrary::Prepared> SceneLibrary::prepare_bytes(const Blob& bytes, const std::string& media_type,
                                                           const std::optional<Environment>& environment,
                                                           const Execution& execution) {
  const ParsePermit permit(parsing_, execution.stop);
  if (!permit.held()) return cancelled();
  Result<Scene> scene = parse(*bytes, media_type);
  if (!scene) return scene.error();
  if (environment) set_environment(*scene, *environment);
  return prepare(std::move(*scene), execution);
}

Result<SceneLibrary::Summary> SceneLibrary::summarize(const Prepared& scene, const Execution& execution) {
  Result<Plan> plan = make_plan(*scene, RenderSettings{}, execution);
  if (!plan) return plan.error();
  SceneSummary summary{make_report(scene->scene), scene->scene.cameras, std::move(*plan)};
  // The cameras are there twice.
  summary.memory_bytes = sizeof summary + 2 * memory_bytes(summary.report) + summary.cameras.size() * sizeof(Camera);
  return std::make_shared<const SceneSummary>(std::move(summary));
}

Result<Camera> choose_camera(const std::vector<Camera>& cameras, const CameraChoice& choice) {
  if (const auto* placed = std::get_if<LookAt>(&choice)) {
    return look_at(placed->eye, placed->target, placed->up, glm::radians(placed->yfov_deg));
  }
  if (const auto* index = std::get_if<std::uint32_t>(&choice)) {
    if (*index < cameras.size()) return cameras[*index];
    return Error{ErrorCode::not_found, "/camera must be from 0 to " + std::to_string(cameras.size() - 1), "/camera"};
  }
  const std::string& name = std::get<std::string>(choice);
  for (const Camera& camera : cameras) {
    if (camera.name == name) return camera;
  }
  return Error{ErrorCode::not_found, unknown_camera(name, cameras), "/camera"};
}

}  // namespace photond
