#include "core/scene/gltf/uri.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace photond::gltf {
namespace {

/// `path` without segments that are "."; nothing where one is empty or "..".
std::optional<std::string> plain_path(std::string_view path) {
  std::string out;
  while (true) {
    const std::size_t slash = path.find('/');
    const std::string_view segment = path.substr(0, slash);
    if (segment.empty() || segment == "..") return std::nullopt;
    if (segment != ".") out.append(out.empty() ? "" : "/").append(segment);
    if (slash == std::string_view::npos) return out;
    path.remove_prefix(slash + 1);
  }
}

/// Value of a base64 digit, −1 where it is none.
int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  return c == '/' ? 63 : -1;
}

}  // namespace

Result<std::vector<std::byte>> decode_data_uri(std::string_view uri, const std::string& where) {
  constexpr std::string_view kMarker = ";base64,";
  const std::size_t marker = uri.find(kMarker);
  if (!is_data_uri(uri) || marker == std::string_view::npos) {
    return invalid_input("data URI is not base64", where);
  }
  std::string_view digits = uri.substr(marker + kMarker.size());
  while (digits.ends_with('=')) digits.remove_suffix(1);
  std::vector<std::byte> out;
  out.reserve(digits.size() / 4 * 3 + 2);
  unsigned bits = 0;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    const int value = base64_value(digits[i]);
    if (value < 0) return invalid_input("data URI is not base64", where);
    bits = bits << 6 | static_cast<unsigned>(value);
    if (i % 4 != 0) out.push_back(static_cast<std::byte>(bits >> (6 - 2 * (i % 4)) & 0xFF));
  }
  return out;
}

bool is_data_uri(std::string_view uri) { return uri.starts_with("data:"); }

Result<std::string> percent_decode(std::string_view uri, const std::string& where) {
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      out.push_back(uri[i]);
      continue;
    }
    unsigned code = 0;
    const char* first = uri.data() + i + 1;
    const bool complete = i + 2 < uri.size();
    if (!complete || std::from_chars(first, first + 2, code, 16).ptr != first + 2) {
      return invalid_input("URI has an incomplete percent escape", where);
    }
    out.push_back(static_cast<char>(code));
    i += 2;
  }
  return out;
}

Result<std::string> check_relative_path(std::string_view path, const std::string& where) {
  const bool control = std::any_of(path.begin(), path.end(),
                                   [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; });
  std::optional<std::string> plain = plain_path(path);
  if (!plain || plain->empty() || control || path.find_first_of("\\:") != std::string_view::npos) {
    return invalid_input("URI is not a plain relative path inside the upload", where);
  }
  return *std::move(plain);
}

}  // namespace photond::gltf
