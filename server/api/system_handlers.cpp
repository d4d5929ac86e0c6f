#include <sstream>

#include "server/api/api.h"
#include "server/api/json.h"
#include "server/api/openapi.h"
#include "server/api/problem.h"
#include "server/api/query.h"

namespace photond {

namespace {

Response text_response(std::string text, const char* type) {
  Response response;
  response.content_type = type;
  response.headers.emplace_back("Cache-Control", "no-store");
  response.body = std::move(text);
  return response;
}

}  // namespace

Response Api::health(const Request&) const { return text_response("ok\n", "text/plain"); }

Response Api::ready(const Request& request) const {
  if (request.stop.stop_requested() || jobs_.stopping()) return problem(503, "draining", "the service is shutting down");
  if (const Status found = jobs_.room().found(); !found) return problem(503, "disk_unreachable", found.error().message);
  if (jobs_.room().full()) return problem(503, "disk_full", "the disk is full; jobs wait until there is room");
  if (const int jobs = jobs_.without_room(); jobs > 0) {
    return text_response("ready; jobs without room on the disk: " + std::to_string(jobs) + "\n", "text/plain");
  }
  return text_response("ready\n", "text/plain");
}

Response Api::info(const Request&) const {
  const JobLimits& jobs = jobs_.limits();
  return json_response({{"name", "photond"},
                        {"version", PHOTOND_VERSION},
                        {"threads", jobs_.threads()},
                        {"methods", {"auto", "path", "photon_map", "progressive", "hybrid"}},
                        {"frame_formats", {"png", "jpg", "exr"}},
                        {"scene_types", {"model/gltf-binary", "model/gltf+json", "application/zip"}},
                        {"limits",
                         {{"max_upload_bytes", limits_.max_upload_bytes},
                          {"max_message_bytes", limits_.max_message_bytes},
                          {"max_pixels", jobs.max_pixels},
                          {"max_job_memory_bytes", jobs.max_job_memory_bytes},
                          {"max_live_jobs", jobs.max_live_jobs},
                          {"max_kept_jobs", jobs.max_kept_jobs},
                          {"map_cache_bytes", jobs.map_cache_bytes},
                          {"map_disk_bytes", jobs_.maps().disk_budget()},
                          {"max_streams", limits_.max_streams},
                          {"max_uploads", limits_.max_uploads},
                          {"max_requests", limits_.max_requests}}}});
}

Response Api::openapi(const Request&) const { return text_response(kOpenApiText, "application/json"); }

}  // namespace photond
