#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <iostream>
#include <mutex>
#include <thread>

#include "server/cli/cli.h"
#include "server/cli/commands.h"
#include "server/cli/interrupt.h"

namespace photond {

namespace {

/// Every connection takes a descriptor, and the usual soft limit of 1024 is soon reached.
void raise_descriptor_limit() {
  rlimit files{};
  getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = files.rlim_max;
  setrlimit(RLIMIT_NOFILE, &files);
}

/// Ends the process, with all its threads as they are, if it still lives some time after the draining has begun. Its
/// thread is made first: when it is needed there may be no more to be had.
class DrainWatch {
 public:
  explicit DrainWatch(std::chrono::milliseconds time)
      : thread_([this, time](const std::stop_token& stop) { watch(time, stop); }) {}

  void begin() {
    const std::lock_guard lock(mutex_);
    begun_ = true;
    changed_.notify_all();
  }

 private:
  void watch(std::chrono::milliseconds time, const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop, [this] { return begun_; });
    changed_.wait_for(lock, stop, time, [] { return false; });
    if (stop.stop_requested()) return;
    LogLine(LogLevel::warning, "drain_cut").with("seconds", std::chrono::duration<double>(time).count());
    std::this_thread::sleep_for(std::chrono::milliseconds(200));  // for the log, which might wait for its reader for ever
    _exit(kExitCut);
  }

  std::mutex mutex_;
  std::condition_variable_any changed_;
  bool begun_ = false;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace

int run_serve(const ServiceOptions& options, LogLevel log_level) {
  raise_descriptor_limit();
  Interrupt interrupt;  // before any thread, which would take its signals
  begin_log(log_level, stderr);
  DrainWatch watch(options.drain_time);
  auto service = Service::start(options);
  if (!service) {
    print_failure("cannot serve", service.error());
    return service.error().code == ErrorCode::invalid_input ? kExitUsage : kExitFailure;
  }
  std::cout << "photond " PHOTOND_VERSION " serves " << (*service)->url() << std::endl;
  interrupt.wait();
  watch.begin();
  service->reset();
  end_log();
  return kExitOk;
}

}  // namespace photond
