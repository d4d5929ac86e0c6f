#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "server/jobs/job_counts.h"
#include "server/store/store.h"

namespace photond {

/// The one way by which jobs change in the store, and the place to wait for it. A reader pulls at its own
/// pace; a slow one finds superseded progress and frame events left out, and delays nobody.
class EventLog {
 public:
  explicit EventLog(Store& store) : store_(store), newest_(store.newest_event()) {}

  /// `also` runs in the transaction that adds the job.
  Status add(JobRecord& job, Event event, const Database::Body& also = {});
  Status update(const JobRecord& job, Event event);
  Status remove(const std::string& job);

  /// Somebody looks at all jobs: see Job::look.
  void look() const { looked_at_ = std::chrono::steady_clock::now(); }
  std::chrono::steady_clock::time_point looked_at() const { return looked_at_; }
  JobCounts::Snapshot counts() const { return counts_.snapshot(); }

  /// The id of the newest event of all jobs; 0 before the first.
  std::uint64_t newest() const;
  /// Waits until `newest()` exceeds `seen`; false after `timeout` or a stop.
  bool wait_beyond(std::uint64_t seen, std::chrono::milliseconds timeout, std::stop_token stop) const;
  /// Events above `after` of one job or (empty) of all, coalesced: every state event, of each job's progress and
  /// frame events only the newest, and of one that is gone only that.
  std::vector<Event> read_after(std::uint64_t after, const std::string& job) const;

 private:
  Status note(const JobRecord& job, const Result<Event>& stored);
  void wake(const Event& stored);

  Store& store_;
  mutable std::mutex mutex_;
  mutable std::condition_variable_any changed_;
  std::uint64_t newest_;
  JobCounts counts_;
  mutable std::atomic<std::chrono::steady_clock::time_point> looked_at_{};
};

}  // namespace photond
