#include "server/api/checked.h"

#include <utility>

#include "server/api/check_request.h"
#include "server/api/problem.h"
#include "server/api/query.h"

namespace photond {

namespace {

bool waits(const Request& request) {
  const Json* wait = parameter(request, "wait");
  return wait != nullptr && *wait != 0;
}

/// The response, keeping `place` until its body has ended.
Response held(Response response, const std::shared_ptr<void>& place) {
  if (auto* pieces = std::get_if<Pieces>(&response.body)) {
    response.body = Pieces([next = std::move(*pieces), place] { return next(); });
  }
  return response;
}

}  // namespace

Admission admission(const Keyring& keys, const Operation& operation) {
  return [&keys, &operation](Request& request) -> std::optional<Response> {
    if (auto refused = authorize(keys, operation, request)) return refused;
    return check_parameters(operation, request);
  };
}

Handler checked(const Operation& operation, OpenStreams& open, bool streams, Handler handler) {
  return [&operation, &open, streams, handler = std::move(handler)](Request& request) {
    if (auto wrong = check_body(operation, request)) return std::move(*wrong);
    if (!streams && !waits(request)) return handler(request);
    const std::shared_ptr<void> place = open.take(request.caller);
    if (!place) return problem(429, "limit_exceeded", "this key has too many streams and long polls open");
    return held(handler(request), place);
  };
}

}  // namespace photond
