#include "server/api/api.h"
#include "server/api/json.h"
#include "server/api/problem.h"
#include "server/store/map_key_text.h"

namespace photond {

namespace {

const char* kind(const MapKey& key) {
  if (is_guide_key(key)) return "guide";
  if (is_irradiance_key(key)) return "irradiance";
  return key.set == PhotonSet::caustic ? "caustic" : "photons";
}

Json map_json(const MapCache::Info& map) {
  return {{"key", key_text(map.key)},
          {"kind", kind(map.key)},
          {"content", to_hex(map.key.scene)},
          {"photons_per_pass", map.key.settings.photons_per_pass},
          {"seed", map.key.settings.seed},
          {"pass", map.key.pass},
          {"bytes", map.bytes},
          {"photons", {{"global", map.facts.global}, {"caustic", map.facts.caustic}}},
          {"memory", map.in_memory},
          {"disk", map.on_disk},
          {"pinned", map.pinned},
          {"hits", map.hits},
          {"build_seconds", map.facts.build_seconds},
          {"last_use", time_text(map.last_use)}};
}

PrewarmSpec parse_prewarm(const Json& message) {
  PrewarmSpec spec;
  spec.scene = *digest_from_hex(message["scene"].get<std::string>());
  spec.photons.photons_per_pass = message.value("photons_per_pass", spec.photons.photons_per_pass);
  spec.photons.seed = message.value("seed", spec.photons.seed);
  if (const auto method = message.find("method"); method != message.end()) {
    spec.method = *method_from_name(method->get<std::string>().c_str());
  }
  spec.passes = message.value("passes", spec.passes);
  return spec;
}

Response no_map() { return problem(404, "not_found", "there is no photon map of this key"); }

}  // namespace

Response Api::list_maps(const Request&) const {
  const MapCache& cache = jobs_.maps();
  const MapCache::Totals totals = cache.totals();
  Json maps = Json::array();
  for (const MapCache::Info& map : cache.list()) maps.push_back(map_json(map));
  return json_response({{"memory", {{"bytes", totals.memory.bytes}, {"budget_bytes", cache.memory_budget()}}},
                        {"disk", {{"bytes", totals.disk.bytes}, {"budget_bytes", cache.disk_budget()}}},
                        {"hits", {{"memory", totals.memory.hits}, {"disk", totals.disk_hits}}},
                        {"misses", totals.misses},
                        {"evictions", {{"memory", totals.memory.evictions}, {"disk", totals.disk.evictions}}},
                        {"maps", std::move(maps)}});
}

Response Api::post_map(const Request& request) {
  const PrewarmSpec spec = parse_prewarm(*request.json);
  const auto prewarmed = jobs_.prewarm(spec, request.caller.key, request.stop);
  if (!prewarmed) return problem(prewarmed.error());
  Json keys = Json::array();
  for (const MapKey& key : prewarmed->keys) keys.push_back(key_text(key));
  const bool ready = prewarmed->ready == prewarmed->keys.size();
  return json_response({{"scene", to_hex(spec.scene)},
                        {"content", to_hex(prewarmed->content)},
                        {"ready", prewarmed->ready},
                        {"keys", std::move(keys)}},
                       ready ? 200 : 202);
}

Response Api::delete_map(const Request& request) {
  const auto key = parse_key(request.captures[0]);
  if (!key) return no_map();
  const bool admin = request.caller.scope == Scope::admin;
  const bool canceled = jobs_.cancel_prewarms(*key, admin ? std::nullopt : std::optional(request.caller.key));
  const bool there = jobs_.maps().find(*key).has_value();
  if (!there && !canceled) return no_map();
  if (there && !admin) return *failed_ownership(request, {});  // maps are everybody's
  if (there) jobs_.maps().erase(*key);
  Response response;
  response.status = 204;
  return response;
}

Response Api::pin_map(const Request& request) { return set_pinned(request, true); }
Response Api::unpin_map(const Request& request) { return set_pinned(request, false); }

Response Api::set_pinned(const Request& request, bool pinned) {
  const auto key = parse_key(request.captures[0]);
  if (!key) return no_map();
  if (const Status done = jobs_.maps().pin(*key, pinned); !done) return problem(done.error());
  const auto map = jobs_.maps().find(*key);
  return map ? json_response(map_json(*map)) : no_map();
}

}  // namespace photond
