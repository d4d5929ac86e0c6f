#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "server/api/message.h"

namespace photond {

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

/// The ETag of an answer; empty where it has none.
inline std::string etag_of(const Response& response) {
  for (const auto& [name, value] : response.headers) {
    if (name == "ETag") return value;
  }
  return {};
}

/// `whole`, an answer 200 with an ETag; where the request's If-None-Match names that, 304 with the same headers.
inline Response unless_known(const Request& request, Response whole) {
  if (!names_etag(request.header("if-none-match"), etag_of(whole))) return whole;
  return {.status = 304, .headers = std::move(whole.headers)};
}

}  // namespace photond
