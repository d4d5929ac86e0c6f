#pragma once

#include <algorithm>
#include <charconv>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "server/api/json.h"
#include "server/api/message.h"

namespace photond {

/// All of `text` as a decimal number without sign.
inline std::optional<std::uint64_t> parse_whole(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

/// A parameter of a request by its name in the contract, which says what type it has and whether it has a default;
/// null where it is absent.
inline const Json* parameter(const Request& request, const char* name) {
  const auto found = request.parameters->find(name);
  return found == request.parameters->end() ? nullptr : &*found;
}

inline std::optional<std::string> text_parameter(const Request& request, const char* name) {
  const Json* value = parameter(request, name);
  return value != nullptr ? std::optional(value->get<std::string>()) : std::nullopt;
}

/// Of a parameter with a default.
inline std::uint64_t whole_parameter(const Request& request, const char* name) {
  return parameter(request, name)->get<std::uint64_t>();
}

/// How long a long poll waits.
inline std::chrono::milliseconds wait_parameter(const Request& request) {
  return std::chrono::milliseconds(1000 * whole_parameter(request, "wait"));
}

/// A strong ETag of this name: the name in quotes.
inline std::string strong_etag(const std::string& name) {
  std::string etag(1, '"');
  etag += name;
  etag += '"';
  return etag;
}

/// Whether an If-None-Match (`weak`: W/ counts as nothing) or If-Match header names the strong `etag`, with its quotes.
inline bool names_etag(std::string_view header, std::string_view etag, bool weak = true) {
  if (header == "*") return true;
  while (!header.empty()) {
    header.remove_prefix(std::min(header.size(), header.find_first_not_of(" \t,")));
    const bool is_weak = header.starts_with("W/");
    if (is_weak) header.remove_prefix(2);
    const std::size_t end = header.starts_with('"') ? header.find('"', 1) : std::string_view::npos;
    if (end == std::string_view::npos) return false;  // not a list of entity tags
    if (header.substr(0, end + 1) == etag && (weak || !is_weak)) return true;
    header.remove_prefix(end + 1);
  }
  return false;
}

/// The answer to an If-None-Match that names what is there.
inline Response not_modified(const std::string& etag) {
  Response response;
  response.status = 304;
  response.headers.emplace_back("ETag", etag);
  return response;
}

}  // namespace photond
