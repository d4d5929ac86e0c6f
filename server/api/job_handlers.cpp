#include <cstdio>

#include "server/api/api.h"
#include "server/api/etag.h"
#include "server/api/job_message.h"
#include "server/api/problem.h"
#include "server/api/query.h"
#include "server/api/wait.h"

namespace photond {

namespace {

std::string job_etag(const JobRecord& job) { return strong_etag(job.id + "." + std::to_string(job.version)); }

Response job_response(const JobRecord& job, int status = 200) {
  Response response = json_response(job_message(job), status);
  response.headers.emplace_back("ETag", job_etag(job));
  return response;
}

/// That the job is what If-Match names, where the request has one.
Job::Guard unchanged(const Request& request) {
  return [wanted = request.header("if-match")](const JobRecord& job) -> Status {
    if (wanted.empty() || names_etag(wanted, job_etag(job), false)) return Done{};
    return failed_match();
  };
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
  wait_until(jobs_.events(), request, [&] {
    if (watched) watched->look();
    job = store_.job(id);
    return !job || known.empty() || !names_etag(known, job_etag(*job));
  });
  if (!job) return no_job(id);
  return unless_known(request, job_response(*job));
}

Response Api::cancel_job(const Request& request) {
  return change_job(request, [this](const auto& id, const auto& guard) { return jobs_.cancel(id, guard); });
}

Response Api::pause_job(const Request& request) {
  return change_job(request, [this](const auto& id, const auto& guard) { return jobs_.pause(id, guard); });
}

Response Api::resume_job(const Request& request) {
  return change_job(request, [this](const auto& id, const auto& guard) { return jobs_.resume(id, guard); });
}

Response Api::extend_job(const Request& request) {
  return change_job(request, [&](const auto& id, const auto& guard) {
    return jobs_.extend(id, parse_stop(*request.json), request.caller.owner(), guard);
  });
}

Response Api::retry_job(const Request& request) {
  return change_job(request, [&](const auto& id, const auto& guard) {
    return jobs_.retry(id, request.caller.owner(), guard);
  });
}

Response Api::change_job(const Request& request, const JobChange& change) {
  if (auto refused = foreign_job(request)) return std::move(*refused);
  const Result<JobRecord> job = change(request.captures[0], unchanged(request));
  return job ? job_response(*job, 202) : problem(job.error());
}

std::optional<Response> Api::foreign_job(const Request& request) const {
  const auto job = store_.job(request.captures[0]);
  if (!job) return std::nullopt;  // for the jobs to tell
  return failed_ownership(request, job->owner);
}

Response Api::delete_job(const Request& request) {
  if (auto refused = foreign_job(request)) return std::move(*refused);
  if (const Status removed = jobs_.remove(request.captures[0], unchanged(request)); !removed) {
    return problem(removed.error());
  }
  Response response;
  response.status = 204;
  return response;
}

Response Api::get_series(const Request& request) const {
  const auto job = store_.job(request.captures[0]);
  return job ? json_response(series_message(*job)) : no_job(request.captures[0]);
}

}  // namespace photond
