#pragma once

#include <string>

#include "core/base/result.h"
#include "server/api/message.h"

namespace photond {

/// An RFC 9457 problem document as a response: application/problem+json with `title`, `status`, `code`,
/// `detail` and, where it is not empty, `pointer` (a JSON pointer into the request, or the place in a file).
Response problem(int status, const std::string& code, const std::string& detail,
                 const std::string& pointer = {});

/// The problem for an error of the layers below.
Response problem(const Error& error);

/// The machine-readable name of an error's kind: "invalid_input", "limit_exceeded", …
const char* error_name(ErrorCode code);

}  // namespace photond
