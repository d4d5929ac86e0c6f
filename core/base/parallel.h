#pragma once

#include <cstddef>
#include <memory>
#include <stop_token>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace photond {

/// Where work runs and when it should stop; passed to every long function of the core.
struct Execution {
  tbb::task_arena* arena = nullptr;  ///< null: run on the calling thread only
  std::stop_token stop;

  bool cancelled() const { return stop.stop_requested(); }
};

/// A set of worker threads at low priority, so that a service sharing the machine stays responsive.
class Workers {
 public:
  /// `threads` 0 means one per core; `nice` is the scheduling niceness (0..19) of the workers. The thread
  /// that waits for the work takes part in it, and should call `lower_priority` once for itself.
  explicit Workers(int threads = 0, int nice = 10);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  int threads() const;
  Execution execution(std::stop_token stop = {}) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Sets the calling thread's niceness; returns false where the system refuses.
bool lower_priority(int nice = 10);

/// Calls `body(i)` for i in [0, n), `grain` consecutive indices per task. Bodies must write to disjoint data
/// and must not depend on the order; after cancellation the remaining indices are skipped.
template <class Body>
void parallel_for(const Execution& execution, std::size_t n, std::size_t grain, const Body& body) {
  auto run = [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      if (execution.cancelled()) return;
      body(i);
    }
  };
  if (execution.arena == nullptr) {
    run({0, n, grain});
    return;
  }
  execution.arena->execute([&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain), run, tbb::simple_partitioner());
  });
}

}  // namespace photond
