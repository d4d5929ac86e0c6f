#include "server/api/api.h"
#include "server/api/problem.h"
#include "server/api/query.h"
#include "server/api/wait.h"

namespace photond {

namespace {

FrameFormat format_of(const std::string& suffix) {
  if (suffix == "png") return FrameFormat::png;
  return suffix == "jpg" ? FrameFormat::jpg : FrameFormat::exr;
}

const char* frame_type(FrameFormat format) {
  switch (format) {
    case FrameFormat::png:
      return "image/png";
    case FrameFormat::jpg:
      return "image/jpeg";
    case FrameFormat::exr:
      return "image/x-exr";
  }
  return "application/octet-stream";
}

std::string frame_etag(const std::string& id, std::uint32_t revision, const std::string& suffix) {
  return strong_etag(id + "." + std::to_string(revision) + "." + suffix);
}

Response no_newer_frame() {
  Response none;
  none.status = 204;
  none.headers.emplace_back("Cache-Control", "no-store");
  return none;
}

}  // namespace

Response Api::get_frame(const Request& request) const {
  const std::string& id = request.captures[0];
  const std::string& suffix = request.captures[2];
  const FrameFormat format = format_of(suffix);
  if (!store_.job(id)) return no_job(id);
  if (request.captures[1] == "latest") return latest_frame(request, format, suffix);
  jobs_.look(id);
  const auto revision = static_cast<std::uint32_t>(whole_parameter(request, "rev"));
  const std::string etag = frame_etag(id, revision, suffix);
  if (names_etag(request.header("if-none-match"), etag)) return not_modified(etag);
  Response response = frame_response(id, revision, format);
  if (response.status != 200) return response;
  response.headers.emplace_back("ETag", etag);
  response.headers.emplace_back("Cache-Control", "private, max-age=31536000, immutable");
  return response;
}

Response Api::latest_frame(const Request& request, FrameFormat format, const std::string& suffix) const {
  const std::string& id = request.captures[0];
  const std::uint64_t after = whole_parameter(request, "after");
  const auto watched = jobs_.job(id);
  std::optional<JobRecord> job;
  wait_until(jobs_.events(), wait_parameter(request), request.stop, [&] {
    if (watched) watched->look();
    job = store_.job(id);
    return !job || job->revision > after || is_terminal(job->state);
  });
  if (!job) return no_job(id);
  if (job->revision <= after) return no_newer_frame();
  const std::string etag = frame_etag(id, job->revision, suffix);
  if (names_etag(request.header("if-none-match"), etag)) return not_modified(etag);
  Response response = frame_response(id, job->revision, format);
  // A job that was put back by a restart has no picture until it has gone on a little.
  if (response.status == 404 && !is_terminal(job->state)) return no_newer_frame();
  if (response.status != 200) return response;
  response.headers.emplace_back("ETag", etag);
  response.headers.emplace_back("Cache-Control", "no-cache");
  response.headers.emplace_back("Content-Location",
                                "/v1/jobs/" + id + "/frames/" + std::to_string(job->revision) + "." + suffix);
  response.headers.emplace_back("Photond-Revision", std::to_string(job->revision));
  return response;
}

Response Api::frame_response(const std::string& id, std::uint32_t revision, FrameFormat format) const {
  const Result<Frames::Bytes> bytes = jobs_.frame(id, revision, format);
  if (!bytes) return problem(bytes.error());
  Response response;
  response.content_type = frame_type(format);
  response.body = *bytes;
  return response;
}

}  // namespace photond
