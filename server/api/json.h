#pragma once

#include <chrono>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "server/api/message.h"

namespace photond {

using Json = nlohmann::ordered_json;

/// Parses a JSON text, refusing more than `kMaxJsonDepth` levels and repeated keys. Errors: invalid_input.
inline constexpr int kMaxJsonDepth = 16;
Result<Json> parse_json(std::span<const std::byte> text);

/// A name as one step of a JSON pointer: ~ and / escaped.
std::string pointer_token(const std::string& name);
/// What a JSON pointer ("" or "/a/0") leads to; null where it leads nowhere.
const Json* find_pointer(const Json& document, std::string_view pointer);

/// A JSON response, not to be stored by caches. Text that is not UTF-8 is repaired.
Response json_response(const Json& body, int status = 200);
std::string to_text(const Json& json);

/// `2026-01-31T12:00:00.123Z`
std::string time_text(std::chrono::system_clock::time_point time);

/// The value, or null where there is none or it is not finite.
template <class T>
Json optional_json(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

}  // namespace photond
