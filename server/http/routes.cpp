#include "server/http/routes.h"

#include <utility>

namespace photond {

namespace {

using Method = Response (Api::*)(const Request&);
using ConstMethod = Response (Api::*)(const Request&) const;

Handler bind(Api& api, Method method) {
  return [&api, method](const Request& request) { return (api.*method)(request); };
}
Handler bind(Api& api, ConstMethod method) {
  return [&api, method](const Request& request) { return (api.*method)(request); };
}

}  // namespace

std::vector<Route> make_routes(Api& api) {
  const std::vector<std::string> scene_types{"model/gltf-binary", "model/gltf+json", "application/zip"};
  const std::uint64_t upload = api.limits().max_upload_bytes;
  const std::uint64_t message = api.limits().max_message_bytes;
  // The first pattern that matches counts.
  return {
      {"GET", "/healthz", bind(api, &Api::health), {}, 0, false},
      {"GET", "/readyz", bind(api, &Api::ready), {}, 0, false},
      {"GET", "/metrics", bind(api, &Api::metrics), {}, 0, false},
      {"GET", "/v1/info", bind(api, &Api::info), {}, 0, false},
      {"GET", "/v1/openapi.json", bind(api, &Api::openapi), {}, 0, false},

      {"POST", "/v1/scenes", bind(api, &Api::post_scene), scene_types, upload, false},
      {"GET", "/v1/scenes", bind(api, &Api::list_scenes), {}, 0, false},
      {"GET", "/v1/scenes/{id}.glb", bind(api, &Api::get_scene_file), {}, 0, false},
      {"GET", "/v1/scenes/{id}", bind(api, &Api::get_scene), {}, 0, false},
      {"DELETE", "/v1/scenes/{id}", bind(api, &Api::delete_scene), {}, 0, false},

      {"POST", "/v1/jobs", bind(api, &Api::post_job), {"application/json"}, message, false},
      {"GET", "/v1/jobs", bind(api, &Api::list_jobs), {}, 0, false},
      {"GET", "/v1/jobs/{id}", bind(api, &Api::get_job), {}, 0, false},
      {"DELETE", "/v1/jobs/{id}", bind(api, &Api::delete_job), {}, 0, false},
      {"POST", "/v1/jobs/{id}/cancel", bind(api, &Api::cancel_job), {}, 0, false},
      {"GET", "/v1/jobs/{id}/series", bind(api, &Api::get_series), {}, 0, false},
      {"GET", "/v1/jobs/{id}/frames/{rev}.{format}", bind(api, &Api::get_frame), {}, 0, false},
      {"GET", "/v1/jobs/{id}/events", bind(api, &Api::job_events), {}, 0, true},
      {"GET", "/v1/events", bind(api, &Api::all_events), {}, 0, true},

      {"GET", "/v1/maps", bind(api, &Api::list_maps), {}, 0, false},
      {"DELETE", "/v1/maps/{key}", bind(api, &Api::delete_map), {}, 0, false},
  };
}

}  // namespace photond
