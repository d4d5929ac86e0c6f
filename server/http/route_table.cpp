#include "server/http/route_table.h"

namespace photond {

namespace {

std::string_view cut_segment(std::string_view& rest) {
  const std::size_t slash = rest.find('/');
  const std::string_view segment = rest.substr(0, slash);
  rest = slash == std::string_view::npos ? std::string_view() : rest.substr(slash + 1);
  return segment;
}

bool match_segment(std::string_view pattern, std::string_view text, std::vector<std::string>& values) {
  if (!pattern.starts_with('{')) return pattern == text;
  const std::string_view ending = pattern.substr(pattern.find('}') + 1);
  const std::size_t dot = ending.empty() ? text.size() : text.rfind('.');
  if (dot == std::string_view::npos || dot == 0) return false;
  values.emplace_back(text.substr(0, dot));
  return ending.empty() || match_segment(ending.substr(1), text.substr(dot + 1), values);
}

}  // namespace

std::optional<std::vector<std::string>> match_path(std::string_view pattern, std::string_view path) {
  std::vector<std::string> values;
  if (!path.starts_with('/')) return std::nullopt;
  while (!pattern.empty() || !path.empty()) {
    if (pattern.empty() != path.empty()) return std::nullopt;
    pattern.remove_prefix(pattern.front() == '/');
    path.remove_prefix(path.front() == '/');
    if (!match_segment(cut_segment(pattern), cut_segment(path), values)) return std::nullopt;
    if (!pattern.empty() && path.empty()) return std::nullopt;
  }
  return values;
}

}  // namespace photond
