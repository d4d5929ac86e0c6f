#pragma once

#include <optional>

#include "server/api/contract.h"
#include "server/api/message.h"

namespace photond {

/// Checks path, query and header fields by the contract and fills `request.parameters`: by name, typed, defaults
/// entered. Returns the problem that lists all mistakes: 404 where the path has one, else 400.
std::optional<Response> check_parameters(const Operation& operation, Request& request);

/// Parses a JSON body, checks it and fills `request.json`; bodies of other types are left alone. Returns the problem:
/// 400 where it is no JSON, else 422.
std::optional<Response> check_body(const Operation& operation, Request& request);

}  // namespace photond
