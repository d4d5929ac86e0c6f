#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "server/api/query.h"
#include "server/jobs/event_log.h"

namespace photond {

/// Calls `look` now, after every change of any job and every second, until it returns true, the request's `wait` is up,
/// it is over or the server stops.
template <class Look>
void wait_until(const EventLog& log, const Request& request, const Look& look) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kLook{1000};  // how soon it is noticed that the request is over
  const Clock::time_point deadline = Clock::now() + wait_parameter(request);
  for (bool over = false; !over;) {
    const std::uint64_t seen = log.newest();  // before looking: what comes in between ends the wait at once
    if (look()) return;
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
    over = left.count() <= 0 || request.stop.stop_requested() || request.is_over();
    if (!over) log.wait_beyond(seen, std::min(left, kLook), request.stop);
  }
}

}  // namespace photond
