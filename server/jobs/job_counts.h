#pragma once

#include <chrono>
#include <map>

#include "server/jobs/guarded.h"
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
    now_.change([&job](Snapshot& now) {
      ++now.moves[job.state];
      if (job.state != JobState::preparing || !job.started) return;
      now.queue_wait.add(std::chrono::duration<double>(*job.started - job.created).count());
    });
  }
  Snapshot snapshot() const { return now_.get(); }

 private:
  Guarded<Snapshot> now_;
};

}  // namespace photond
