#pragma once

#include <chrono>
#include <mutex>
#include <stop_token>

namespace photond {

/// Waits for `mutex`; owns it unless `stop` has asked before.
inline std::unique_lock<std::timed_mutex> take_turn(std::timed_mutex& mutex, const std::stop_token& stop) {
  std::unique_lock turn(mutex, std::defer_lock);
  while (!stop.stop_requested() && !turn.try_lock_for(std::chrono::milliseconds(50))) continue;
  return turn;
}

}  // namespace photond
