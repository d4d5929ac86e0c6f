#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/api/message.h"

namespace photond {

/// Which of the limited seats a request takes while it is served: of each kind so many are served at once.
enum class Seat {
  request,
  upload,  ///< a large body in memory
  stream,  ///< an endless answer
  probe    ///< none: health and metrics are told however full the house is
};

/// One line of the route table. A pattern's segment is a literal, `{name}` or `{name}.` followed by either.
struct Route {
  std::string method;
  std::string pattern;
  Admission admit;  ///< may refuse, or check and complete the head, before a body is read
  Handler handler;
  std::vector<std::string> body_types{};  ///< accepted Content-Types; empty: the route takes no body
  std::uint64_t max_body_bytes = 0;
  Seat seat = Seat::request;
};

/// The placeholders' values where `path` matches `pattern`.
std::optional<std::vector<std::string>> match_path(std::string_view pattern, std::string_view path);

}  // namespace photond
