#include "server/api/api.h"
#include "server/api/etag.h"
#include "server/api/problem.h"
#include "server/api/query.h"
#include "server/api/wait.h"

namespace photond {

/// Which of a revision's pictures is asked for.
struct FrameWish {
  std::string suffix;
  FrameFormat format = FrameFormat::png;
  FrameLayer layer = FrameLayer::radiance;

  bool of_error() const { return layer != FrameLayer::radiance; }
};

namespace {

FrameWish read_wish(const Request& request) {
  FrameWish wish{request.captures[2]};
  if (wish.suffix == "jpg") wish.format = FrameFormat::jpg;
  if (wish.suffix == "exr") wish.format = FrameFormat::exr;
  const auto layer = text_parameter(request, "layer");
  for (const FrameLayer known : {FrameLayer::noise, FrameLayer::bias, FrameLayer::bound}) {
    if (layer == layer_name(known)) wish.layer = known;
  }
  return wish;
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

std::string frame_etag(const std::string& id, std::uint32_t revision, const FrameWish& wish) {
  const std::string layer = wish.of_error() ? std::string(layer_name(wish.layer)) + "." : "";
  return strong_etag(id + "." + std::to_string(revision) + "." + layer + wish.suffix);
}

std::string frame_path(const std::string& id, std::uint32_t revision, const FrameWish& wish) {
  const std::string query = wish.of_error() ? std::string("?layer=") + layer_name(wish.layer) : "";
  return "/v1/jobs/" + id + "/frames/" + std::to_string(revision) + "." + wish.suffix + query;
}

void look(const Job& job, const FrameWish& wish) {
  job.look();
  if (wish.of_error()) job.look_at_error();
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
  const FrameWish wish = read_wish(request);
  const auto job = jobs_.job(id);
  if (!job) return no_job(id);
  if (request.captures[1] == "latest") return latest_frame(request, wish);
  look(*job, wish);
  const auto revision = static_cast<std::uint32_t>(whole_parameter(request, "rev"));
  Response response = frame_response(id, revision, wish);
  if (response.status != 200) return response;
  response.headers.emplace_back("ETag", frame_etag(id, revision, wish));
  response.headers.emplace_back("Cache-Control", "private, max-age=31536000, immutable");
  return unless_known(request, std::move(response));
}

Response Api::latest_frame(const Request& request, const FrameWish& wish) const {
  const std::string& id = request.captures[0];
  const std::uint64_t after = whole_parameter(request, "after");
  const auto watched = jobs_.job(id);
  std::optional<JobRecord> job;
  Response response;
  wait_until(jobs_.events(), request, [&] {
    if (watched) look(*watched, wish);
    job = store_.job(id);
    if (!job || job->revision <= after) return !job || is_terminal(job->state);
    response = frame_response(id, job->revision, wish);
    // A job that was put back by a restart has no picture until it has gone on a little, and pictures come with their
    // error from the first look at it on.
    return response.status != 404 || is_terminal(job->state) || job->state == JobState::paused;
  });
  if (!job) return no_job(id);
  // Of a paused job no picture comes with its error before it goes on.
  const bool may_come = !is_terminal(job->state) && !(wish.of_error() && job->state == JobState::paused);
  if (job->revision <= after || (response.status == 404 && may_come)) return no_newer_frame();
  if (response.status != 200) return response;
  response.headers.emplace_back("ETag", frame_etag(id, job->revision, wish));
  response.headers.emplace_back("Cache-Control", "no-cache");
  response.headers.emplace_back("Content-Location", frame_path(id, job->revision, wish));
  response.headers.emplace_back("Photond-Revision", std::to_string(job->revision));
  return unless_known(request, std::move(response));
}

Response Api::frame_response(const std::string& id, std::uint32_t revision, const FrameWish& wish) const {
  Response response;
  response.content_type = frame_type(wish.format);
  if (!wish.of_error()) {
    // What is on the disk goes out from there: a slow reader must not hold a large picture in memory.
    if (const auto file = jobs_.frame_file(id, revision, wish.format)) {
      response.body = *file;
      return response;
    }
  }
  const Result<Frames::Bytes> bytes = jobs_.frame(id, revision, wish.format, wish.layer);
  if (!bytes) return problem(bytes.error());
  response.body = *bytes;
  return response;
}

}  // namespace photond
