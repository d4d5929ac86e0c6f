#include "server/jobs/job.h"

#include <utility>

namespace photond {

namespace {

constexpr const char* kNames[kJobStates] = {"queued",    "preparing", "rendering", "finalizing",
                                            "succeeded", "canceling", "canceled",  "failed"};

Event event_of(const JobRecord& job, EventKind kind) {
  Event event;
  event.kind = kind;
  event.time = std::chrono::system_clock::now();
  event.job = job.id;
  event.state = job.state;
  event.version = job.version;
  event.passes = job.passes;
  event.seconds = job.seconds;
  event.rejected = job.rejected;
  event.error = job.error;
  event.eta_seconds = job.eta_seconds;
  event.map_hits = job.map_hits;
  event.map_misses = job.map_misses;
  event.revision = job.revision;
  return event;
}

void stamp(JobRecord& job) {
  const WallTime now = std::chrono::system_clock::now();
  if (job.state == JobState::preparing) job.started = now;
  if (!is_terminal(job.state)) return;
  job.finished = now;
  job.eta_seconds.reset();
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

bool may_move(JobState from, JobState to) {
  if (is_terminal(from) || from == to) return false;
  if (from == JobState::canceling) return to == JobState::canceled || to == JobState::failed;
  if (to == JobState::canceling || to == JobState::failed) return true;
  return static_cast<int>(to) == static_cast<int>(from) + 1;  // the straight way, in the order of the enum
}

JobRecord Job::record() const {
  const std::lock_guard lock(mutex_);
  return record_;
}

JobState Job::state() const {
  const std::lock_guard lock(mutex_);
  return record_.state;
}

Status Job::move(JobState to, const Edit& edit) {
  const std::lock_guard lock(mutex_);
  if (!may_move(record_.state, to)) {
    return Error{ErrorCode::conflict,
                 std::string("a job that is ") + state_name(record_.state) + " cannot become " + state_name(to),
                 ""};
  }
  JobRecord changed = record_;
  if (edit) edit(changed);
  changed.state = to;
  stamp(changed);
  return store(std::move(changed), EventKind::state);
}

Status Job::note(EventKind kind, const Edit& edit) {
  const std::lock_guard lock(mutex_);
  JobRecord changed = record_;
  edit(changed);
  return store(std::move(changed), kind);
}

Status Job::store(JobRecord&& changed, EventKind kind) {
  ++changed.version;
  const Status stored = log_.update(changed, event_of(changed, kind));
  if (stored) record_ = std::move(changed);
  return stored;
}

Status Job::cancel() {
  const JobState now = state();
  if (now == JobState::canceling || now == JobState::canceled) return Done{};
  const Status moved = move(JobState::canceling);
  const JobState after = state();
  if (!moved && after != JobState::canceling && after != JobState::canceled) return moved;
  stop_.request_stop();
  return Done{};
}

}  // namespace photond
