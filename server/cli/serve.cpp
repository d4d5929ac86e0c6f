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

/// Ends the process, with all its threads as they are, if the returned object still lives after `time`.
std::jthread watch_drain(std::chrono::milliseconds time) {
  return std::jthread([time](const std::stop_token& stop) {
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any never;
    never.wait_for(lock, stop, time, [] { return false; });
    if (stop.stop_requested()) return;
    LogLine(LogLevel::warning, "drain_cut").with("seconds", std::chrono::duration<double>(time).count());
    std::this_thread::sleep_for(std::chrono::milliseconds(200));  // for the log, which might wait for its reader for ever
    _exit(kExitCut);
  });
}

}  // namespace

int run_serve(const ServiceOptions& options, LogLevel log_level) {
  raise_descriptor_limit();
  Interrupt interrupt;  // before any thread, which would take its signals
  begin_log(log_level, stderr);
  auto service = Service::start(options);
  if (!service) {
    print_failure("cannot serve", service.error());
    return service.error().code == ErrorCode::invalid_input ? kExitUsage : kExitFailure;
  }
  std::cout << "photond " PHOTOND_VERSION " serves " << (*service)->url() << std::endl;
  interrupt.wait();
  const std::jthread watch = watch_drain(options.drain_time);
  service->reset();
  end_log();
  return kExitOk;
}

}  // namespace photond
