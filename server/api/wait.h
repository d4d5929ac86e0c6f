#pragma once

#include <chrono>
#include <cstdint>
#include <stop_token>

#include "server/jobs/event_log.h"

namespace photond {

/// Calls `look` after every change of any job until it returns true, the time is up or the server stops.
template <class Look>
bool wait_until(const EventLog& log, std::chrono::milliseconds wait, const std::stop_token& stop, const Look& look) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point deadline = Clock::now() + wait;
  while (true) {
    const std::uint64_t seen = log.newest();  // before looking: what comes in between ends the wait at once
    if (look()) return true;
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
    if (left.count() <= 0 || stop.stop_requested() || !log.wait_beyond(seen, left, stop)) return look();
  }
}

}  // namespace photond
