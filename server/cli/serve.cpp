#include <sys/resource.h>

#include <csignal>
#include <iostream>

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

}  // namespace

int run_serve(const ServiceOptions& options, LogLevel log_level) {
  raise_descriptor_limit();
  Interrupt interrupt;  // before any thread, which would take its signals
  begin_log(log_level, stderr);
  std::signal(SIGPIPE, SIG_IGN);  // a client that hangs up is an error of one write, not of the program
  const auto service = Service::start(options);
  if (!service) {
    print_failure("cannot serve", service.error());
    return service.error().code == ErrorCode::invalid_input ? kExitUsage : kExitFailure;
  }
  std::cout << "photond " PHOTOND_VERSION " serves " << (*service)->url() << std::endl;
  interrupt.wait();
  (*service)->stop();
  end_log();
  return kExitOk;
}

}  // namespace photond
