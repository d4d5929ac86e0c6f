#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <tuple>

#include "server/jobs/histogram.h"

namespace photond {

/// What the transport counts for /metrics. Thread-safe.
class RequestCounts {
 public:
  /// `route` is the pattern of the route table, never the path: its values are few.
  using Key = std::tuple<std::string, std::string, int>;  ///< method, route, status

  /// `refusal` is the code of the problem that was answered; empty where it was none. `seconds` until the answer's
  /// first byte.
  void answered(const Key& key, const std::string& refusal, double seconds) {
    const std::lock_guard lock(mutex_);
    ++now_.answers[key];
    if (!refusal.empty()) ++now_.refusals[refusal];
    now_.seconds.add(seconds);
  }
  /// A connection ended without an answer, for this reason.
  void dropped(const std::string& reason) {
    const std::lock_guard lock(mutex_);
    ++now_.drops[reason];
  }
  /// Endless answers and long polls.
  void streams_changed(int by) {
    const std::lock_guard lock(mutex_);
    now_.streams += by;
  }

  struct Snapshot {
    std::map<Key, std::uint64_t> answers;
    std::map<std::string, std::uint64_t> refusals;
    std::map<std::string, std::uint64_t> drops;
    Histogram<8> seconds{{0.001, 0.005, 0.02, 0.05, 0.25, 1, 5, 20}};
    int streams = 0;  ///< open now
  };
  Snapshot snapshot() const {
    const std::lock_guard lock(mutex_);
    return now_;
  }

 private:
  mutable std::mutex mutex_;
  Snapshot now_;
};

}  // namespace photond
