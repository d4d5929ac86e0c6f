#pragma once

#include <charconv>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "server/api/message.h"

namespace photond {

/// All of `text` as a decimal number without sign.
inline std::optional<std::uint64_t> parse_whole(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

/// The whole number of a query key, `missing` where it is absent. Errors: invalid_input with `where` "?key".
inline Result<std::uint64_t> query_whole(const Request& request, const std::string& key, std::uint64_t missing,
                                         std::uint64_t min, std::uint64_t max) {
  const auto text = request.query_value(key);
  if (!text) return missing;
  const auto value = parse_whole(*text);
  if (value && *value >= min && *value <= max) return *value;
  return invalid_input("the query's " + key + " must be a whole number from " + std::to_string(min) + " to " +
                           std::to_string(max),
                       "?" + key);
}

/// How long a long poll waits: the query's `wait`, 0 … 60 seconds.
inline Result<std::chrono::milliseconds> query_wait(const Request& request) {
  const Result<std::uint64_t> seconds = query_whole(request, "wait", 0, 0, 60);
  if (!seconds) return seconds.error();
  return std::chrono::milliseconds(1000 * *seconds);
}

/// A strong ETag of this name: the name in quotes.
inline std::string strong_etag(const std::string& name) {
  std::string etag(1, '"');
  etag += name;
  etag += '"';
  return etag;
}

/// Whether an If-None-Match header names `etag` (with its quotes).
inline bool names_etag(const std::string& header, const std::string& etag) {
  return header == "*" || header.find(etag) != std::string::npos;
}

}  // namespace photond
