#include "server/http/route_table.h"

namespace photond {

namespace {

/// What stands between the slashes; a trailing slash has an empty segment behind it.
std::vector<std::string_view> segments_of(std::string_view path) {
  std::vector<std::string_view> segments;
  while (path.starts_with('/')) {
    path.remove_prefix(1);
    const std::size_t slash = path.find('/');
    segments.push_back(path.substr(0, slash));
    path = slash == std::string_view::npos ? std::string_view() : path.substr(slash);
  }
  return segments;
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
  const std::vector<std::string_view> wanted = segments_of(pattern);
  const std::vector<std::string_view> given = segments_of(path);
  if (wanted.size() != given.size()) return std::nullopt;
  std::vector<std::string> values;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!match_segment(wanted[i], given[i], values)) return std::nullopt;
  }
  return values;
}

}  // namespace photond
