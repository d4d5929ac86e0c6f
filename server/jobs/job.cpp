#include "server/jobs/job.h"

#include <utility>

namespace photond {

namespace {

constexpr const char* kNames[kJobStates] = {"queued",    "preparing", "rendering", "finalizing", "succeeded",
                                            "canceling", "canceled",  "failed",    "paused"};

Event event_of(const JobRecord& job, EventKind kind) {
  Event event;
  static_cast<JobNumbers&>(event) = job;
  event.kind = kind;
  event.time = std::chrono::system_clock::now();
  event.job = job.id;
  return event;
}

void stamp(JobRecord& job) {
  const WallTime now = std::chrono::system_clock::now();
  if (job.state == JobState::preparing && !job.started) job.started = now;
  if (job.state != JobState::paused) job.pause_reason = PauseReason::none;
  if (!is_terminal(job.state)) return job.finished.reset();
  job.finished = now;
  job.eta_seconds.reset();
}

Error cannot_move(JobState from, JobState to) {
  return {ErrorCode::conflict,
          std::string("a job that is ") + state_name(from) + " cannot become " + state_name(to), ""};
}

}  // namespace

const char* state_name(JobState state) { return kNames[static_cast<int>(state)]; }

std::optional<JobState> state_from_name(const std::string& name) {
  for (int i = 0; i < kJobStates; ++i) {
    if (name == kNames[i]) return static_cast<JobState>(i);
  }
  return std::nullopt;
}

bool is_terminal(JobState state) {
  return state == JobState::succeeded || state == JobState::canceled || state == JobState::failed;
}

bool is_running(JobState state) {
  return state == JobState::preparing || state == JobState::rendering || state == JobState::finalizing;
}

bool may_move(JobState from, JobState to) {
  const bool on_its_way = from == JobState::queued || is_running(from);
  switch (to) {
    case JobState::queued:
      return is_running(from) || from == JobState::paused || from == JobState::succeeded || from == JobState::failed;
    case JobState::preparing:
      return from == JobState::queued;
    case JobState::rendering:
      return from == JobState::preparing;
    case JobState::finalizing:
      return from == JobState::rendering;
    case JobState::succeeded:
      return from == JobState::finalizing;
    case JobState::canceling:
      return on_its_way || from == JobState::paused;
    case JobState::canceled:
      return from == JobState::canceling;
    case JobState::failed:
    case JobState::paused:
      return on_its_way;
  }
  return false;
}

JobRecord Job::record() const {
  const std::lock_guard lock(mutex_);
  return record_;
}

JobState Job::state() const {
  const std::lock_guard lock(mutex_);
  return record_.state;
}

StopRule Job::stop_rule() const {
  const std::lock_guard lock(mutex_);
  return record_.spec.stop;
}

PauseReason Job::pause_reason() const {
  const std::lock_guard lock(mutex_);
  return record_.pause_reason;
}

Status Job::move(JobState to, const Edit& edit, const Guard& guard) {
  const std::lock_guard lock(mutex_);
  if (const Status fine = guard ? guard(record_) : Status(Done{}); !fine) return fine;
  if (!may_move(record_.state, to)) return cannot_move(record_.state, to);
  return move_now(to, edit);
}

Status Job::pause(const Guard& guard) {
  const std::lock_guard lock(mutex_);
  if (const Status fine = guard ? guard(record_) : Status(Done{}); !fine) return fine;
  if (record_.pause_reason == PauseReason::request) return Done{};
  if (record_.state != JobState::paused && !may_move(record_.state, JobState::paused)) {
    return cannot_move(record_.state, JobState::paused);
  }
  return move_now(JobState::paused, [](JobRecord& record) { record.pause_reason = PauseReason::request; });
}

Status Job::note(EventKind kind, const Edit& edit) {
  const std::lock_guard lock(mutex_);
  JobRecord changed = record_;
  edit(changed);
  return store(std::move(changed), kind);
}

Status Job::move_now(JobState to, const Edit& edit) {
  JobRecord changed = record_;
  if (edit) edit(changed);
  changed.state = to;
  stamp(changed);
  return store(std::move(changed), EventKind::state);
}

Status Job::store(JobRecord&& changed, EventKind kind) {
  ++changed.version;
  const Status stored = log_.update(changed, event_of(changed, kind));
  if (stored) record_ = std::move(changed);
  return stored;
}

}  // namespace photond
