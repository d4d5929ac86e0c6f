#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/api/message.h"
#include "server/http/head.h"

namespace photond {

/// Which other sites' pages may use the service from a browser (Fetch standard, §3.3). None unless named.
class Cors {
 public:
  Cors() = default;
  /// Origins as browsers send them, `https://example.org`. Errors: invalid_input for what is none.
  static Result<Cors> of(std::vector<std::string> origins);

  const std::vector<std::string>& origins() const { return origins_; }
  /// Whether the request comes from a page of one of them.
  bool allows(const Head& head) const;
  /// The answer to a browser that asks whether it may send one of `methods` here; nothing where this is no such question.
  std::optional<Response> preflight(const Head& head, const std::string& methods) const;
  /// Lets the page see the answer.
  void mark(const Head& head, Response& response) const;

 private:
  std::vector<std::string> origins_;
};

}  // namespace photond
