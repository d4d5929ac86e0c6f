#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "server/store/file.h"
#include "server/store/keys.h"

namespace photond {

/// Who asks, by the key that was sent; where no keys are required, nobody in particular, who may do everything.
struct Caller {
  std::string key;  ///< its id
  Scope scope = Scope::admin;
  KeyLimits limits;

  Owner owner() const { return {key, limits, scope == Scope::admin}; }
  /// Whether what `owner` (id of a key) has made is the caller's to change.
  bool may_change(const std::string& owner) const { return this->owner().may_change(owner); }
};

/// A request as the handlers see it. Header values come from outside and are never echoed.
struct Request {
  std::string method;                             ///< "GET" (HEAD too), "POST", "DELETE"
  std::string path;                               ///< percent-decoded, without the query
  std::string id;                                 ///< X-Request-Id: for logs, told in the answer
  std::vector<std::string> captures;              ///< what the route's placeholders matched
  std::multimap<std::string, std::string> query;  ///< percent-decoded
  std::string content_type;                       ///< lower case, without parameters
  std::map<std::string, std::string> headers;     ///< names in lower case, values as sent; see `header`
  std::string peer;                               ///< the other end's address
  Caller caller;
  std::vector<std::byte> body;
  std::shared_ptr<const nlohmann::ordered_json> parameters;  ///< of path, query and headers, checked: see query.h
  std::shared_ptr<const nlohmann::ordered_json> json;        ///< a JSON body, checked
  std::stop_token stop;  ///< triggered when the server shuts down
  /// Whether nobody waits for the answer any more: the client has closed its end, or may not have it by now.
  std::function<bool()> is_over = [] { return false; };

  /// The value of a header, named in lower case; empty where it is absent. Of a repeated one the first.
  std::string header(const std::string& name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? std::string() : found->second;
  }
};

using SharedBytes = std::shared_ptr<const std::vector<std::byte>>;

/// The next piece of an endless body: waits at most about a second, then returns what there is (perhaps
/// nothing); no value at the end.
using Pieces = std::function<std::optional<std::string>()>;

struct Response {
  int status = 200;
  std::string content_type;
  std::vector<std::pair<std::string, std::string>> headers;
  std::variant<std::string, SharedBytes, FileBytes, Pieces> body;
  std::string refusal;  ///< the code of a problem, for logs and metrics; else empty
};

/// What looks at a request before its body is read, and what answers it; they throw nothing of their own.
using Admission = std::function<std::optional<Response>(Request&)>;
using Handler = std::function<Response(Request&)>;

}  // namespace photond
