#include "server/http/routes.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "server/api/checked.h"
#include "server/api/contract.h"

namespace photond {

namespace {

using Method = Response (Api::*)(const Request&);
using ConstMethod = Response (Api::*)(const Request&) const;
using Upload = Response (Api::*)(Request&);  ///< takes the body away

/// One line of the table below: what answers an operation of the contract.
struct Line {
  Line(std::string m, std::string p, Method h, std::uint64_t body = 0)
      : method(std::move(m)), pattern(std::move(p)), max_body_bytes(body), call([h](Api& api, Request& request) {
          return (api.*h)(request);
        }) {}
  Line(std::string m, std::string p, ConstMethod h, Seat w = Seat::request)
      : method(std::move(m)), pattern(std::move(p)), seat(w), call([h](Api& api, Request& request) {
          return (api.*h)(request);
        }) {}
  Line(std::string m, std::string p, Upload h, std::uint64_t body)
      : method(std::move(m)), pattern(std::move(p)), max_body_bytes(body), seat(Seat::upload),
        call([h](Api& api, Request& request) { return (api.*h)(request); }) {}

  std::string method;
  std::string pattern;
  std::uint64_t max_body_bytes = 0;
  Seat seat = Seat::request;
  std::function<Response(Api&, Request&)> call;
};

/// The first pattern that matches counts.
std::vector<Line> table(const ApiLimits& limits) {
  return {
      {"GET", "/healthz", &Api::health, Seat::probe},
      {"GET", "/readyz", &Api::ready, Seat::probe},
      {"GET", "/metrics", &Api::metrics, Seat::probe},
      {"GET", "/v1/info", &Api::info},
      {"GET", "/v1/openapi.json", &Api::openapi},

      {"POST", "/v1/scenes", &Api::post_scene, limits.max_upload_bytes},
      {"GET", "/v1/scenes", &Api::list_scenes},
      {"GET", "/v1/scenes/{id}.glb", &Api::get_scene_file},
      {"GET", "/v1/scenes/{id}", &Api::get_scene},
      {"DELETE", "/v1/scenes/{id}", &Api::delete_scene},

      {"POST", "/v1/environments", &Api::post_environment, limits.max_upload_bytes},
      {"GET", "/v1/environments", &Api::list_environments},
      {"GET", "/v1/environments/{id}", &Api::get_environment},
      {"DELETE", "/v1/environments/{id}", &Api::delete_environment},

      {"POST", "/v1/jobs", &Api::post_job, limits.max_message_bytes},
      {"GET", "/v1/jobs", &Api::list_jobs},
      {"GET", "/v1/jobs/{id}", &Api::get_job},
      {"DELETE", "/v1/jobs/{id}", &Api::delete_job},
      {"POST", "/v1/jobs/{id}/cancel", &Api::cancel_job},
      {"POST", "/v1/jobs/{id}/pause", &Api::pause_job},
      {"POST", "/v1/jobs/{id}/resume", &Api::resume_job},
      {"POST", "/v1/jobs/{id}/extend", &Api::extend_job, limits.max_message_bytes},
      {"POST", "/v1/jobs/{id}/retry", &Api::retry_job},
      {"GET", "/v1/jobs/{id}/series", &Api::get_series},
      {"GET", "/v1/jobs/{id}/frames/{rev}.{format}", &Api::get_frame},
      {"GET", "/v1/jobs/{id}/checkpoint", &Api::get_checkpoint},
      {"GET", "/v1/jobs/{id}/stream.mjpg", &Api::picture_stream, Seat::stream},
      {"GET", "/v1/jobs/{id}/events", &Api::job_events, Seat::stream},
      {"GET", "/v1/events", &Api::all_events, Seat::stream},

      {"GET", "/v1/maps", &Api::list_maps},
      {"POST", "/v1/maps", &Api::post_map, limits.max_message_bytes},
      {"POST", "/v1/maps/{key}/pin", &Api::pin_map},
      {"POST", "/v1/maps/{key}/unpin", &Api::unpin_map},
      {"DELETE", "/v1/maps/{key}", &Api::delete_map},
  };
}

Route make_route(Api& api, Line line, const Operation& operation) {
  Route route{line.method, line.pattern, {}, {}, {}, line.max_body_bytes, line.seat};
  for (const auto& [type, schema] : operation.body) route.body_types.push_back(type);
  route.admit = admission(api.keys(), operation);
  const auto call = [&api, call = std::move(line.call)](Request& request) { return call(api, request); };
  route.handler = checked(api.keys(), operation, api.streams(), line.seat == Seat::stream, call);
  return route;
}

}  // namespace

Result<std::vector<Route>> make_routes(Api& api) {
  std::vector<Route> routes;
  for (Line& line : table(api.limits())) {
    const Operation* operation = api.contract().find(line.method, line.pattern);
    if (operation == nullptr)
      return Error{ErrorCode::internal, "the contract lacks " + line.method + " " + line.pattern, ""};
    routes.push_back(make_route(api, std::move(line), *operation));
  }
  for (const Operation& operation : api.contract().operations()) {
    const bool answered = std::any_of(routes.begin(), routes.end(), [&operation](const Route& route) {
      return route.method == operation.method && route.pattern == operation.pattern;
    });
    if (!answered) return Error{ErrorCode::internal, "nothing answers " + operation.id + " of the contract", ""};
  }
  return routes;
}

}  // namespace photond
