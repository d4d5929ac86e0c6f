#include <algorithm>
#include <cstdio>
#include <iterator>

#include "server/api/api.h"
#include "server/api/etag.h"
#include "server/api/problem.h"
#include "server/api/query.h"
#include "server/api/scene_message.h"

namespace photond {

namespace {

Response no_scene() { return problem(404, "not_found", "there is no scene of this id"); }

/// A place in the list of scenes as a cursor; the texts are ordered as the list is. New scenes come last, so that they
/// move nothing, and a scene that goes leaves its place.
std::string place_of(const SceneRecord& scene) {
  char text[24];
  std::snprintf(text, sizeof text, "c-%c%016llx", scene.sample ? '0' : '1',
                static_cast<unsigned long long>(scene.arrival));
  return text;
}

std::string scene_etag(const Response& response) {
  const std::string& body = std::get<std::string>(response.body);
  return strong_etag(to_hex(sha256(std::as_bytes(std::span(body.data(), body.size())))).substr(0, 32));
}

std::optional<SceneRecord> find_scene(const Store& store, const Request& request) {
  const auto id = digest_from_hex(request.captures[0]);
  return id ? store.scene(*id) : std::nullopt;
}

}  // namespace

Response Api::post_scene(Request& request) {
  const Result<SceneLibrary::Added> added =
      jobs_.scenes().add(std::move(request.body), request.content_type, text_parameter(request, "name").value_or(""),
                         request.caller.owner(), request.stop);
  if (!added) return problem(added.error());
  const auto summary = jobs_.scenes().summary(added->scene.id, request.stop);
  if (!summary) return problem(summary.error());
  Response response = json_response(scene_message(added->scene, summary->get()), added->fresh ? 201 : 200);
  response.headers.emplace_back("Location", "/v1/scenes/" + to_hex(added->scene.id));
  return response;
}

Response Api::list_scenes(const Request& request) const {
  const std::vector<SceneRecord> scenes = store_.scenes();
  auto scene = scenes.begin();
  if (const auto cursor = text_parameter(request, "cursor"))
    scene = std::find_if(scene, scenes.end(), [&](const SceneRecord& next) { return place_of(next) > *cursor; });
  Json list = Json::array();
  const std::uint64_t limit = whole_parameter(request, "limit");
  for (; scene != scenes.end() && list.size() < limit; ++scene) list.push_back(scene_message(*scene, nullptr));
  const Json next = scene == scenes.end() ? Json(nullptr) : Json(place_of(*std::prev(scene)));
  return json_response({{"scenes", std::move(list)}, {"next_cursor", next}});
}

Response Api::get_scene(const Request& request) {
  const auto scene = find_scene(store_, request);
  if (!scene) return no_scene();
  const auto summary = jobs_.scenes().summary(scene->id, request.stop);
  if (!summary) return problem(summary.error());
  Response response = json_response(scene_message(*scene, summary->get()));
  response.headers.emplace_back("ETag", scene_etag(response));
  return unless_known(request, std::move(response));
}

Response Api::get_scene_file(const Request& request) const {
  const auto scene = find_scene(store_, request);
  if (!scene) return no_scene();
  if (scene->media_type != "model/gltf-binary") {
    return problem(404, "not_found", "this scene was uploaded as " + scene->media_type + ", not as a GLB");
  }
  const std::string etag = strong_etag(to_hex(scene->id));
  Response response;
  response.headers.emplace_back("ETag", etag);
  response.headers.emplace_back("Cache-Control", "private, max-age=31536000, immutable");
  if (names_etag(request.header("if-none-match"), etag)) {
    response.status = 304;
    return response;
  }
  const Result<FileBytes> file = store_.scene_file(scene->id);
  if (!file) return problem(file.error());
  response.content_type = scene->media_type;
  response.body = *file;
  return response;
}

Response Api::delete_scene(const Request& request) {
  const auto scene = find_scene(store_, request);
  if (!scene) return no_scene();
  if (auto refused = failed_ownership(request, scene->owner)) return std::move(*refused);
  if (const Status removed = jobs_.remove_scene(scene->id); !removed) return problem(removed.error());
  Response response;
  response.status = 204;
  return response;
}

}  // namespace photond
