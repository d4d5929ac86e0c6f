#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace photond {

inline constexpr std::size_t kMaxHeadBytes = 16 * 1024;  ///< request line and header lines together

/// What a request says of itself before its body.
struct Head {
  std::string method;
  std::string target;  ///< "/path?query" as sent, printable ASCII; what it decodes to has no control characters
  bool http10 = false;
  /// Names in lower case, values as sent without the space around them; a repeated list joined by ", ".
  std::map<std::string, std::string> fields;
  bool chunked = false;
  std::optional<std::uint64_t> length;  ///< of the body, where stated
  bool expects_continue = false;

  bool has_body() const { return chunked || length.value_or(0) > 0; }
  /// The value of a field; empty where it is absent.
  std::string field(const std::string& name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? std::string() : found->second;
  }
};

/// Why a head is not served.
struct BadHead {
  int status = 400;
  std::string detail;
};

/// Reads a whole head, its empty last line included, as strictly as RFC 9112 allows: what two parsers might read
/// differently (lengths stated twice, bare line feeds, folded lines, spaces before a colon) is refused.
std::variant<Head, BadHead> parse_head(std::string_view text);

}  // namespace photond
