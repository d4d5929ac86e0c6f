#pragma once

#include <atomic>
#include <stop_token>
#include <thread>

namespace photond {

/// Turns SIGINT and SIGTERM into a stop request. Construct it before any other thread, since threads inherit
/// the blocked signals. A second signal ends the process at once.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  std::stop_token token() const { return source_.get_token(); }
  /// The signal that came, or 0.
  int signal() const { return signal_; }
  /// Returns when a signal has come.
  void wait() const;

 private:
  void watch();

  std::stop_source source_;
  std::atomic<int> signal_ = 0;
  std::atomic<bool> done_ = false;
  std::thread thread_;
};

}  // namespace photond
