#include <csignal>
#include <iostream>

#include "server/cli/cli.h"
#include "server/cli/commands.h"
#include "server/cli/interrupt.h"

namespace photond {

int run_serve(const ServiceOptions& options) {
  Interrupt interrupt;
  std::signal(SIGPIPE, SIG_IGN);  // a client that hangs up is an error of one write, not of the program
  const auto service = Service::start(options);
  if (!service) {
    print_failure("cannot serve", service.error());
    return service.error().code == ErrorCode::invalid_input ? kExitUsage : kExitFailure;
  }
  std::cout << "photond " PHOTOND_VERSION " serves " << (*service)->url() << std::endl;
  interrupt.wait();
  (*service)->stop();
  return kExitOk;
}

}  // namespace photond
