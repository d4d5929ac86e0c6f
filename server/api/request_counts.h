#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <tuple>

namespace photond {

/// What the transport counts for /metrics. Thread-safe.
class RequestCounts {
 public:
  /// `route` is the pattern of the route table, never the path: its values are few.
  using Key = std::tuple<std::string, std::string, int>;  ///< method, route, status

  void answered(const std::string& method, const std::string& route, int status) {
    const std::lock_guard lock(mutex_);
    ++answers_[{method, route, status}];
  }
  void refused() {
    const std::lock_guard lock(mutex_);
    ++refusals_;
  }
  void streams_changed(int by) {
    const std::lock_guard lock(mutex_);
    streams_ += by;
  }

  struct Snapshot {
    std::map<Key, std::uint64_t> answers;
    std::uint64_t refusals = 0;  ///< 503 because too many were served at once
    int streams = 0;             ///< event streams and long polls open now
  };
  Snapshot snapshot() const {
    const std::lock_guard lock(mutex_);
    return {answers_, refusals_, streams_};
  }

 private:
  mutable std::mutex mutex_;
  std::map<Key, std::uint64_t> answers_;
  std::uint64_t refusals_ = 0;
  int streams_ = 0;
};

}  // namespace photond
