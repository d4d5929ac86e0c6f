#include "server/api/api.h"
#include "server/api/etag.h"
#include "server/api/problem.h"
#include "server/api/range.h"

namespace photond {

Response Api::get_checkpoint(const Request& request) const {
  const auto checkpoint = jobs_.checkpoint(request.captures[0]);
  if (!checkpoint) return problem(checkpoint.error());
  const std::string etag = strong_etag(to_hex(checkpoint->about.blob));
  Response response;
  response.headers.emplace_back("ETag", etag);
  response.headers.emplace_back("Cache-Control", "no-cache");
  response.headers.emplace_back("Photond-Passes", std::to_string(checkpoint->about.passes));
  if (names_etag(request.header("if-none-match"), etag)) {
    response.status = 304;
    return response;
  }
  response.content_type = "application/octet-stream";
  response.body = checkpoint->bytes;
  return ranged(request, std::move(response));
}

}  // namespace photond
