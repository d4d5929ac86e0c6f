#include "server/http/cors.h"

#include <algorithm>
#include <regex>
#include <utility>

namespace photond {

Result<Cors> Cors::of(std::vector<std::string> origins) {
  static const std::regex kOrigin("https?://[a-z0-9.-]{1,200}(:[0-9]{1,5})?");
  for (const std::string& origin : origins) {
    if (origin.size() <= 256 && std::regex_match(origin, kOrigin)) continue;
    return invalid_input("an origin is written as https://example.org, with its port where it has one and no path");
  }
  Cors cors;
  cors.origins_ = std::move(origins);
  return cors;
}

bool Cors::allows(const Head& head) const {
  return std::find(origins_.begin(), origins_.end(), head.field("origin")) != origins_.end();
}

std::optional<Response> Cors::preflight(const Head& head, const std::string& methods) const {
  if (head.method != "OPTIONS" || head.field("access-control-request-method").empty() || !allows(head)) return std::nullopt;
  Response response;
  response.status = 204;
  response.headers = {{"Access-Control-Allow-Methods", methods},
                      {"Access-Control-Allow-Headers",
                       "Authorization, Content-Type, Idempotency-Key, If-Match, If-None-Match, If-Range, Last-Event-ID, Range"},
                      {"Access-Control-Max-Age", "600"}};
  return response;
}

void Cors::mark(const Head& head, Response& response) const {
  if (origins_.empty()) return;
  response.headers.emplace_back("Vary", "Origin");
  if (!allows(head)) return;
  response.headers.emplace_back("Access-Control-Allow-Origin", head.field("origin"));  // one of ours, so it is clean
  response.headers.emplace_back("Access-Control-Expose-Headers",
                                "Accept-Ranges, Content-Location, Content-Range, ETag, Idempotency-Replayed, Location, Photond-Passes, "
                                "Photond-Revision, Retry-After, WWW-Authenticate, X-Request-Id");
}

}  // namespace photond
