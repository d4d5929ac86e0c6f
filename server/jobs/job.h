#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "server/jobs/event_log.h"
#include "server/jobs/frames.h"
#include "server/store/records.h"

namespace photond {

const char* state_name(JobState state);  ///< "queued", "preparing", …
std::optional<JobState> state_from_name(const std::string& name);
bool is_terminal(JobState state);  ///< succeeded, canceled, failed
bool is_running(JobState state);   ///< preparing, rendering, finalizing
/// The moves a job can make: queued → preparing → rendering → finalizing → succeeded; from any of these to paused or
/// failed; to canceling, also from paused, and from there to canceled. Back to queued goes what is resumed (paused),
/// continued (succeeded), tried again (failed) or put back by an end of the service (preparing to finalizing).
bool may_move(JobState from, JobState to);

/// A job while the process knows it: its record, its pictures, and its one door for changes.
class Job {
 public:
  using Edit = std::function<void(JobRecord&)>;
  /// What must hold of the job that a change starts from; its error is that of the change.
  using Guard = std::function<Status(const JobRecord&)>;

  /// `record` is stored already.
  Job(JobRecord record, EventLog& log) : spec(record.spec), id(record.id), owner(record.owner), log_(log), record_(std::move(record)) {}

  /// As submitted; the stop rule may have been replaced since, see `stop_rule`.
  const JobSpec spec;
  const std::string id;
  const std::string owner;

  JobRecord record() const;
  JobState state() const;
  StopRule stop_rule() const;
  PauseReason pause_reason() const;

  /// Moves to `to` after `edit`: bumps the version, stamps the time and appends an event, all or nothing, and nothing
  /// happens to the job between `guard` and that. Errors: the guard's, conflict where the state forbids it, the store's.
  Status move(JobState to, const Edit& edit = {}, const Guard& guard = {});
  /// Moves to paused by request; of a job that is paused for want of room that becomes the reason. Errors: as `move`.
  Status pause(const Guard& guard = {});
  /// Changes numbers within the state and appends an event of `kind`.
  Status note(EventKind kind, const Edit& edit);

  /// Somebody looks at the job: for a while its pictures are worth publishing. Making it is a look.
  void look() const { looked_at_ = std::chrono::steady_clock::now(); }
  /// When somebody last looked at it, or at all jobs.
  std::chrono::steady_clock::time_point looked_at() const { return std::max(looked_at_.load(), log_.looked_at()); }
  /// Somebody looks at its error: for a while its pictures come with it.
  void look_at_error() const { error_looked_at_ = std::chrono::steady_clock::now(); }
  std::chrono::steady_clock::time_point error_looked_at() const { return error_looked_at_; }

  Frames frames;

 private:
  Status move_now(JobState to, const Edit& edit);
  Status store(JobRecord&& changed, EventKind kind);

  EventLog& log_;
  mutable std::mutex mutex_;
  JobRecord record_;
  mutable std::atomic<std::chrono::steady_clock::time_point> looked_at_{std::chrono::steady_clock::now()};
  mutable std::atomic<std::chrono::steady_clock::time_point> error_looked_at_{std::chrono::steady_clock::time_point()};
};

}  // namespace photond
