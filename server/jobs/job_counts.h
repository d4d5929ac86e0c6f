#pragma once

#include <chrono>
#include <map>
#include <mutex>

#include "server/jobs/histogram.h"
#include "server/store/records.h"

namespace photond {

/// What /metrics tells of jobs beyond those that are known at the moment. Thread-safe.
class JobCounts {
 public:
  struct Snapshot {
    std::map<JobState, std::uint64_t> moves;  ///< into each state, since the start
    Histogram<9> queue_wait{{0.01, 0.1, 0.5, 1, 2, 5, 15, 60, 300}};
  };

  /// A job has moved into the state that it is in.
  void moved(const JobRecord& job) {
    const std::lock_guard lock(mutex_);
    ++now_.moves[job.state];
    if (job.state != JobState::preparing || !job.started) return;
    now_.queue_wait.add(std::chrono::duration<double>(*job.started - job.created).count());
  }
  Snapshot snapshot() const {
    const std::lock_guard lock(mutex_);
    return now_;
  }

 private:
  mutable std::mutex mutex_;
  Snapshot now_;
};

}  // namespace photond
