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

/// Asks again what the caller was asked at first: a key may be revoked meanwhile, and the first one made.
using Refusal = std::function<std::optional<Response>()>;

/// The response, keeping `place`, until its body has ended or the caller is refused.
Response held(Response response, const std::shared_ptr<void>& place, const Refusal& refused) {
  if (auto* pieces = std::get_if<Pieces>(&response.body)) {
    response.body = Pieces([next = std::move(*pieces), place, refused] {
      std::optional<std::string> piece = next();
      return refused() ? std::nullopt : piece;
    });
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

Handler checked(const Keyring& keys, const Operation& operation, OpenStreams& open, bool streams, Handler handler) {
  return [&keys, &operation, &open, streams, handler = std::move(handler)](Request& request) {
    if (auto wrong = check_body(operation, request)) return std::move(*wrong);
    if (!streams && !waits(request)) return handler(request);
    const std::shared_ptr<void> place = open.take(request.caller);
    if (!place) return problem(429, "limit_exceeded", "this key has too many streams and long polls open");
    const Refusal refused = [&keys, &operation, asked = request]() mutable {
      return authorize(keys, operation, asked);
    };
    request.is_over = [gone = std::move(request.is_over), refused] { return gone() || refused(); };
    Response response = handler(request);
    if (auto refusal = refused()) return std::move(*refusal);
    return held(std::move(response), place, refused);
  };
}

}  // namespace photond
