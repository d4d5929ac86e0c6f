#include "server/api/api.h"
#include "server/api/json.h"
#include "server/api/problem.h"
#include "server/api/query.h"

namespace photond {

namespace {

Json environment_message(const EnvironmentRecord& environment) {
  return {{"id", to_hex(environment.id)},
          {"name", environment.name},
          {"media_type", environment.media_type},
          {"bytes", environment.bytes},
          {"width", environment.width},
          {"height", environment.height},
          {"warnings", environment.warnings},
          {"created_at", time_text(environment.created)}};
}

}  // namespace

Response Api::post_environment(Request& request) {
  const auto added =
      jobs_.environments().add(std::move(request.body), text_parameter(request, "name").value_or(""),
                               request.caller.owner(), request.stop);
  if (!added) return problem(added.error());
  Response response = json_response(environment_message(added->environment), added->fresh ? 201 : 200);
  response.headers.emplace_back("Location", "/v1/environments/" + to_hex(added->environment.id));
  return response;
}

Response Api::get_environment(const Request& request) const {
  const auto id = digest_from_hex(request.captures[0]);
  if (!id) return problem(404, "not_found", "there is no environment of this id");
  const auto environment = jobs_.environments().find(*id);
  return environment ? json_response(environment_message(*environment)) : problem(environment.error());
}

Response Api::list_environments(const Request&) const {
  const auto environments = jobs_.environments().list();
  if (!environments) return problem(environments.error());
  Json list = Json::array();
  for (const EnvironmentRecord& environment : *environments) list.push_back(environment_message(environment));
  return json_response({{"environments", std::move(list)}});
}

Response Api::delete_environment(const Request& request) {
  const auto id = digest_from_hex(request.captures[0]);
  if (!id) return problem(404, "not_found", "there is no environment of this id");
  const auto environment = jobs_.environments().find(*id);
  if (!environment) return problem(environment.error());
  if (auto refused = failed_ownership(request, environment->owner)) return std::move(*refused);
  if (const Status removed = jobs_.remove_environment(*id); !removed) return problem(removed.error());
  Response response;
  response.status = 204;
  return response;
}

}  // namespace photond
