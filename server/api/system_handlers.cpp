#include <sstream>

#include "server/api/api.h"
#include "server/api/json.h"
#include "server/api/openapi.h"
#include "server/api/problem.h"
#include "server/api/query.h"

namespace photond {

namespace {

Response text_response(std::string text, const char* type) {
  Response response;
  response.content_type = type;
  response.headers.emplace_back("Cache-Control", "no-store");
  response.body = std::move(text);
  return response;
}

/// `content-photons-seed-pass`, the content being the scene's digest without cameras and names.
std::string key_text(const MapKey& key) {
  return to_hex(key.scene) + "-" + std::to_string(key.settings.photons_per_pass) + "-" +
         std::to_string(key.settings.seed) + "-" + std::to_string(key.pass);
}

std::optional<MapKey> parse_key(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, '-');) parts.push_back(part);
  if (parts.size() != 4) return std::nullopt;
  const auto scene = digest_from_hex(parts[0]);
  const auto photons = parse_whole(parts[1]);
  const auto seed = parse_whole(parts[2]);
  const auto pass = parse_whole(parts[3]);
  if (!scene || !photons || !seed || !pass || *photons > UINT32_MAX || *pass > UINT32_MAX) return std::nullopt;
  return MapKey{*scene, {static_cast<std::uint32_t>(*photons), *seed}, static_cast<std::uint32_t>(*pass)};
}

Json map_json(const MapCache::Info& map) {
  return {{"key", key_text(map.key)},
          {"content", to_hex(map.key.scene)},
          {"photons_per_pass", map.key.settings.photons_per_pass},
          {"seed", map.key.settings.seed},
          {"pass", map.key.pass},
          {"bytes", map.value->memory_bytes},
          {"photons", {{"global", map.value->global.size()}, {"caustic", map.value->caustic.size()}}},
          {"hits", map.hits},
          {"build_seconds", map.build_seconds},
          {"last_use", time_text(map.last_use)}};
}

}  // namespace

Response Api::health(const Request&) const { return text_response("ok\n", "text/plain"); }

Response Api::ready(const Request& request) const {
  if (request.stop.stop_requested()) return problem(503, "draining", "the service is shutting down");
  return text_response("ready\n", "text/plain");
}

Response Api::info(const Request&) const {
  const JobLimits& jobs = jobs_.limits();
  return json_response({{"name", "photond"},
                        {"version", PHOTOND_VERSION},
                        {"threads", jobs_.threads()},
                        {"methods", {"auto", "path", "photon_map", "progressive", "hybrid"}},
                        {"frame_formats", {"png", "jpg", "exr"}},
                        {"scene_types", {"model/gltf-binary", "model/gltf+json", "application/zip"}},
                        {"limits",
                         {{"max_upload_bytes", limits_.max_upload_bytes},
                          {"max_message_bytes", limits_.max_message_bytes},
                          {"max_pixels", jobs.max_pixels},
                          {"max_live_jobs", jobs.max_live_jobs},
                          {"max_kept_jobs", jobs.max_kept_jobs},
                          {"map_cache_bytes", jobs.map_cache_bytes},
                          {"max_streams", limits_.max_streams},
                          {"max_uploads", limits_.max_uploads},
                          {"max_requests", limits_.max_requests}}}});
}

Response Api::openapi(const Request&) const { return text_response(kOpenApiText, "application/json"); }

Response Api::list_maps(const Request&) const {
  const MapCache::Totals totals = jobs_.maps().totals();
  Json maps = Json::array();
  for (const MapCache::Info& map : jobs_.maps().list()) maps.push_back(map_json(map));
  return json_response({{"budget_bytes", jobs_.maps().budget_bytes()},
                        {"bytes", totals.bytes},
                        {"hits", totals.hits},
                        {"misses", totals.misses},
                        {"evictions", totals.evictions},
                        {"maps", std::move(maps)}});
}

Response Api::delete_map(const Request& request) {
  const auto key = parse_key(request.captures[0]);
  if (!key || !jobs_.maps().erase(*key)) return problem(404, "not_found", "there is no photon map of this key");
  Response response;
  response.status = 204;
  return response;
}

}  // namespace photond
