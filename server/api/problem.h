#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/api/message.h"

namespace photond {

/// An RFC 9457 problem document as a response: application/problem+json with `title`, `status`, `code`,
/// `detail` and, where it is not empty, `pointer` (a JSON pointer into the request, or the place in a file).
Response problem(int status, const std::string& code, const std::string& detail,
                 const std::string& pointer = {});

/// A way in which a request breaks the contract.
struct Violation {
  std::string where;   ///< JSON pointer into the body, or ?name of a query key, {name} of a part of the path, a header
  std::string detail;  ///< "/film/width must be a whole number from 1 to 16384"
};

/// The problem for several mistakes: `detail` and `pointer` are those of the first, `errors` lists all.
Response problem(int status, const std::string& code, const std::vector<Violation>& violations);

/// 404 of a job.
Response no_job(const std::string& id);

/// 403 where what `owner` (id of a key) has made is not the caller's to change.
std::optional<Response> failed_ownership(const Request& request, const std::string& owner);

/// The error that becomes 412: what If-Match names is not there any more.
Error failed_match();

/// The problem for an error of the layers below.
Response problem(const Error& error);

/// The machine-readable name of an error's kind: "invalid_input", "limit_exceeded", …
const char* error_name(ErrorCode code);

}  // namespace photond
