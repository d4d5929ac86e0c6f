#include <cstdio>

#include "server/api/api.h"
#include "server/api/job_message.h"
#include "server/api/problem.h"
#include "server/api/query.h"

namespace photond {

namespace {

using Clock = std::chrono::steady_clock;

Response no_job(const std::string& id) { return problem(404, "not_found", "there is no job " + id); }

std::string job_etag(const JobRecord& job) { return strong_etag(job.id + "." + std::to_string(job.version)); }

Response job_response(const JobRecord& job, int status = 200) {
  Response response = json_response(job_message(job), status);
  response.headers.emplace_back("ETag", job_etag(job));
  return response;
}

Response accepted(const std::string& id, Response response) {
  response.headers.emplace_back("Location", "/v1/jobs/" + id);
  return response;
}

Response submitted(const Result<JobRecord>& job) {
  return job ? accepted(job->id, job_response(*job, 202)) : problem(job.error());
}

Response replayed(const StoredAnswer& answer) {
  Response response;
  response.status = answer.status;
  response.content_type = "application/json";
  response.headers = {{"Cache-Control", "no-store"}, {"ETag", answer.etag}, {"Idempotency-Replayed", "true"}};
  response.body = answer.body;
  return accepted(answer.job, std::move(response));
}

/// Calls `look` after every change of any job until it returns true, the time is up or the server stops.
template <class Look>
bool wait_until(const EventLog& log, std::chrono::milliseconds wait, const std::stop_token& stop,
                const Look& look) {
  const Clock::time_point deadline = Clock::now() + wait;
  while (true) {
    const std::uint64_t seen = log.newest();  // before looking: what comes in between ends the wait at once
    if (look()) return true;
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
    if (left.count() <= 0 || stop.stop_requested() || !log.wait_beyond(seen, left, stop)) return look();
  }
}

/// A place in the list of jobs as a cursor, and back. It names the job before it, so that new jobs move nothing.
std::string cursor_at(std::uint64_t sequence) {
  char text[24];
  std::snprintf(text, sizeof text, "c-%016llx", static_cast<unsigned long long>(sequence));
  return text;
}
std::uint64_t place_of(const std::string& cursor) { return std::stoull(cursor.substr(2), nullptr, 16); }

struct JobFilter {
  std::optional<JobState> state;
  std::optional<Digest> scene;
  std::optional<std::string> label;
  std::uint64_t before = UINT64_MAX;  ///< sequence number: the cursor

  bool admits(const JobRecord& job) const {
    return job.sequence < before && (!state || job.state == *state) && (!scene || job.spec.scene == *scene) &&
           (!label || job.spec.label == *label);
  }
};

JobFilter read_filter(const Request& request) {
  JobFilter filter;
  if (const auto name = text_parameter(request, "state")) filter.state = state_from_name(*name);
  if (const auto id = text_parameter(request, "scene")) filter.scene = digest_from_hex(*id);
  filter.label = text_parameter(request, "label");
  if (const auto cursor = text_parameter(request, "cursor")) filter.before = place_of(*cursor);
  return filter;
}

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

Response not_modified(const std::string& etag) {
  Response response;
  response.status = 304;
  response.headers.emplace_back("ETag", etag);
  return response;
}

}  // namespace

Response Api::post_job(const Request& request) {
  const Result<JobSpec> spec = parse_job(*request.json);
  if (!spec) return problem(spec.error());
  if (*parameter(request, "dry_run") == true) {
    const Result<JobEstimate> estimate = jobs_.estimate(*spec, request.stop);
    if (!estimate) return problem(estimate.error());
    return json_response({{"spec", spec_message(*spec)},
                          {"plan", plan_message(estimate->plan)},
                          {"estimate",
                           {{"passes", estimate->passes},
                            {"seconds", estimate->seconds},
                            {"memory_bytes", estimate->memory_bytes}}}});
  }
  const auto key = text_parameter(request, "Idempotency-Key");
  return key ? submit_once(request, *spec, *key) : submitted(jobs_.submit(*spec, request.caller.owner(), request.stop));
}

Response Api::submit_once(const Request& request, const JobSpec& spec, const std::string& key) {
  const std::string& owner = request.caller.key;
  const std::shared_ptr<void> turn = underway_.take(owner, key);
  if (!turn) {
    Response busy = problem(409, "idempotency_key_busy", "a request of this Idempotency-Key is being answered");
    busy.headers.emplace_back("Retry-After", "1");
    return busy;
  }
  const Digest body = sha256(request.body);
  const WallTime now = std::chrono::system_clock::now();
  const Result<std::optional<StoredAnswer>> before = answers_.find(owner, key, now);
  if (!before) return problem(before.error());
  if (*before) {
    if ((*before)->request == body) return replayed(**before);
    return problem(422, "idempotency_key_reused", "this Idempotency-Key came with another body before",
                   "Idempotency-Key");
  }
  const auto keep = [&](Transaction& transaction, const JobRecord& job) {
    return Answers::put(transaction, owner, key, {body, job.id, job_etag(job), 202, to_text(job_message(job))}, now);
  };
  return submitted(jobs_.submit(spec, request.caller.owner(), request.stop, keep));
}

Response Api::list_jobs(const Request& request) const {
  const JobFilter filter = read_filter(request);
  const std::uint64_t limit = whole_parameter(request, "limit");
  Json list = Json::array();
  Json next = nullptr;
  std::uint64_t last = 0;
  for (const JobRecord& job : store_.jobs()) {
    if (!filter.admits(job)) continue;
    if (list.size() == limit) {
      next = cursor_at(last);
      break;
    }
    last = job.sequence;
    list.push_back(job_message(job));
  }
  return json_response({{"jobs", std::move(list)}, {"next_cursor", next}});
}

Response Api::get_job(const Request& request) const {
  const std::string& id = request.captures[0];
  std::optional<JobRecord> job;
  const std::string known = request.header("if-none-match");
  const auto watched = jobs_.job(id);
  const bool changed = wait_until(jobs_.events(), wait_parameter(request), request.stop, [&] {
    if (watched) watched->look();
    job = store_.job(id);
    return !job || known.empty() || !names_etag(known, job_etag(*job));
  });
  if (!job) return no_job(id);
  return changed ? job_response(*job) : not_modified(job_etag(*job));
}

Response Api::cancel_job(const Request& request) {
  if (auto refused = refused_change(request)) return std::move(*refused);
  const Result<JobRecord> job = jobs_.cancel(request.captures[0]);
  return job ? job_response(*job, 202) : problem(job.error());
}

Response Api::pause_job(const Request& request) {
  if (auto refused = refused_change(request)) return std::move(*refused);
  const Result<JobRecord> job = jobs_.pause(request.captures[0]);
  return job ? job_response(*job, 202) : problem(job.error());
}

Response Api::resume_job(const Request& request) {
  if (auto refused = refused_change(request)) return std::move(*refused);
  const Result<JobRecord> job = jobs_.resume(request.captures[0]);
  return job ? job_response(*job, 202) : problem(job.error());
}

Response Api::extend_job(const Request& request) {
  if (auto refused = refused_change(request)) return std::move(*refused);
  const Result<JobRecord> job = jobs_.extend(request.captures[0], parse_stop(*request.json), request.caller.owner());
  return job ? job_response(*job, 202) : problem(job.error());
}

Response Api::retry_job(const Request& request) {
  if (auto refused = refused_change(request)) return std::move(*refused);
  const Result<JobRecord> job = jobs_.retry(request.captures[0], request.caller.owner());
  return job ? job_response(*job, 202) : problem(job.error());
}

std::optional<Response> Api::refused_change(const Request& request) const {
  const auto job = store_.job(request.captures[0]);
  if (!job) return std::nullopt;  // for the jobs to tell
  if (auto refused = failed_ownership(request, job->owner)) return refused;
  return failed_match(request, job_etag(*job));
}

Response Api::delete_job(const Request& request) {
  if (auto refused = refused_change(request)) return std::move(*refused);
  if (const Status removed = jobs_.remove(request.captures[0]); !removed) return problem(removed.error());
  Response response;
  response.status = 204;
  return response;
}

Response Api::get_series(const Request& request) const {
  const auto job = store_.job(request.captures[0]);
  return job ? json_response(series_message(*job)) : no_job(request.captures[0]);
}

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
