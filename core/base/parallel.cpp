#include "core/base/parallel.h"

#include <cerrno>

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <tbb/task_scheduler_observer.h>

namespace photond {

bool lower_priority(int nice) {
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  errno = 0;
  if (const int current = getpriority(PRIO_PROCESS, thread); errno == 0 && current >= nice) return true;
  return setpriority(PRIO_PROCESS, thread, nice) == 0;
}

namespace {

class PriorityObserver : public tbb::task_scheduler_observer {
 public:
  PriorityObserver(tbb::task_arena& arena, int nice) : tbb::task_scheduler_observer(arena), nice_(nice) {
    observe(true);
  }
  ~PriorityObserver() override { observe(false); }
  void on_scheduler_entry(bool is_worker) override {
    if (is_worker) lower_priority(nice_);
  }

 private:
  int nice_;
};

}  // namespace

struct Workers::State {
  State(int threads, int nice)
      : arena(threads > 0 ? threads : tbb::task_arena::automatic), observer(arena, nice) {}
  tbb::task_arena arena;
  PriorityObserver observer;
};

Workers::Workers(int threads, int nice) : state_(std::make_unique<State>(threads, nice)) {}
Workers::~Workers() = default;

int Workers::threads() const { return state_->arena.max_concurrency(); }

Execution Workers::execution(std::stop_token stop) const { return {&state_->arena, std::move(stop)}; }

}  // namespace photond
