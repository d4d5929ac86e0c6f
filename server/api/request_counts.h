#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>

#include "server/jobs/guarded.h"
#include "server/jobs/histogram.h"

namespace photond {

/// What the transport counts for /metrics. Thread-safe.
class RequestCounts {
 public:
  /// `route` is the pattern of the route table, never the path: its values are few.
  using Key = std::tuple<std::string, std::string, int>;  ///< method, route, status
  struct Snapshot {
    std::map<Key, std::uint64_t> answers;
    std::map<std::string, std::uint64_t> refusals;
    std::map<std::string, std::uint64_t> drops;
    Histogram<8> seconds{{0.001, 0.005, 0.02, 0.05, 0.25, 1, 5, 20}};
    int streams = 0;  ///< open now
  };

  /// `refusal` is the code of the problem that was answered; empty where it was none. `seconds` until the answer's
  /// first byte.
  void answered(const Key& key, const std::string& refusal, double seconds) {
    now_.change([&](Snapshot& now) {
      ++now.answers[key];
      if (!refusal.empty()) ++now.refusals[refusal];
      now.seconds.add(seconds);
    });
  }
  /// A connection ended without an answer, for this reason.
  void dropped(const std::string& reason) {
    now_.change([&reason](Snapshot& now) { ++now.drops[reason]; });
  }
  /// Endless answers and long polls.
  void streams_changed(int by) {
    now_.change([by](Snapshot& now) { now.streams += by; });
  }

  Snapshot snapshot() const { return now_.get(); }

 private:
  Guarded<Snapshot> now_;
};

}  // namespace photond
