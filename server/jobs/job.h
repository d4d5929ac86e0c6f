#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

#include "server/jobs/event_log.h"
#include "server/jobs/frames.h"
#include "server/store/records.h"

namespace photond {

const char* state_name(JobState state);  ///< "queued", "preparing", …
std::optional<JobState> state_from_name(const std::string& name);
bool is_terminal(JobState state);  ///< succeeded, canceled, failed
/// The moves a job can make: queued → preparing → rendering → finalizing → succeeded, from any of these to
/// canceling → canceled, and from any to failed.
bool may_move(JobState from, JobState to);

/// A job while the process knows it: its record, its pictures, and its one door for changes.
class Job {
 public:
  using Edit = std::function<void(JobRecord&)>;

  /// `record` is stored already.
  Job(JobRecord record, EventLog& log) : log_(log), record_(std::move(record)) {}

  const JobSpec& spec() const { return record_.spec; }
  const std::string& id() const { return record_.id; }
  JobRecord record() const;
  JobState state() const;

  /// Moves to `to` after `edit`: bumps the version, stamps the time and appends an event, all or nothing.
  /// Errors: conflict where the state forbids it, or the store's.
  Status move(JobState to, const Edit& edit = {});
  /// Changes numbers within the state and appends an event of `kind`.
  Status note(EventKind kind, const Edit& edit);

  /// Asks for the end: moves to canceling and triggers the stop token. Asking twice is no error; conflict
  /// where the job has ended otherwise.
  Status cancel();
  std::stop_token stop() const { return stop_.get_token(); }

  Frames frames;

 private:
  Status store(JobRecord&& changed, EventKind kind);

  EventLog& log_;
  mutable std::mutex mutex_;
  JobRecord record_;  ///< spec and id never change
  std::stop_source stop_;
};

}  // namespace photond
