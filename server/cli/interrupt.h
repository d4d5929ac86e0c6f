#pragma once

#include <atomic>
#include <stop_token>
#include <thread>

namespace photond {

/// Turns SIGINT, SIGTERM and SIGHUP into a stop request; SIGHUP not where it is ignored, as nohup does. Construct it
/// before any other thread, since threads inherit the blocked signals. A further signal ends the process at once, with
/// 128 + the signal and without half a file (files.h), unless it comes so soon that it means the same: a terminal that
/// is closed, and timeout(1), send two.
class Interrupt {
 public:
  /// Which signal ends the process at once.
  enum class Ends { at_second, at_first };

  explicit Interrupt(Ends ends = Ends::at_second);
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

  const Ends ends_;
  std::stop_source source_;
  std::atomic<int> signal_ = 0;
  std::atomic<bool> done_ = false;
  std::thread thread_;
};

}  // namespace photond
