#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/api/message.h"

namespace photond {

/// One line of the route table. A pattern's segment is a literal, `{name}` or `{name}.` followed by either.
struct Route {
  std::string method;
  std::string pattern;
  Admission admit;  ///< may refuse, or check and complete the head, before a body is read
  Handler handler;
  std::vector<std::string> body_types;  ///< accepted Content-Types; empty: the route takes no body
  std::uint64_t max_body_bytes = 0;
  bool streams = false;  ///< answers with an endless body
};

/// The placeholders' values where `path` matches `pattern`.
std::optional<std::vector<std::string>> match_path(std::string_view pattern, std::string_view path);

}  // namespace photond
