#pragma once

#include <functional>

namespace photond {

/// Runs `work` in a copy of this process, so that nothing it does is seen here, and tells whether it came to its end:
/// not if it crashed, nor if it took more seconds of a core. For work that cannot be interrupted, before it is done here.
/// `work` must wait for no other thread: the copy has none.
bool ends_within(int cpu_seconds, const std::function<void()>& work);

}  // namespace photond
