#pragma once

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

}  // namespace photond
