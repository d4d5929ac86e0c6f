#include "server/api/api.h"
#include "server/api/problem.h"
#include "server/api/query.h"
#include "server/api/scene_message.h"

namespace photond {

namespace {

Response no_scene() { return problem(404, "not_found", "there is no scene of this id"); }

std::optional<SceneRecord> find_scene(const Store& store, const Request& request) {
  const auto id = digest_from_hex(request.captures[0]);
  return id ? store.scene(*id) : std::nullopt;
}

}  // namespace

Response Api::post_scene(const Request& request) {
  const Result<SceneLibrary::Added> added =
      jobs_.scenes().add(request.body, request.content_type, request.stop);
  if (!added) return problem(added.error());
  const auto summary = jobs_.scenes().summary(added->scene.id, request.stop);
  if (!summary) return problem(summary.error());
  Response response = json_response(scene_message(added->scene, summary->get()), added->fresh ? 201 : 200);
  response.headers.emplace_back("Location", "/v1/scenes/" + to_hex(added->scene.id));
  return response;
}

Response Api::list_scenes(const Request&) const {
  Json list = Json::array();
  for (const SceneRecord& scene : store_.scenes()) list.push_back(scene_message(scene, nullptr));
  return json_response({{"scenes", std::move(list)}});
}

Response Api::get_scene(const Request& request) {
  const auto scene = find_scene(store_, request);
  if (!scene) return no_scene();
  const auto summary = jobs_.scenes().summary(scene->id, request.stop);
  if (!summary) return problem(summary.error());
  return json_response(scene_message(*scene, summary->get()));
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
  const Result<Blob> bytes = store_.scene_bytes(scene->id);
  if (!bytes) return problem(bytes.error());
  response.content_type = scene->media_type;
  response.body = *bytes;
  return response;
}

Response Api::delete_scene(const Request& request) {
  const auto scene = find_scene(store_, request);
  if (!scene) return no_scene();
  if (const Status removed = jobs_.remove_scene(scene->id); !removed) return problem(removed.error());
  Response response;
  response.status = 204;
  return response;
}

}  // namespace photond
