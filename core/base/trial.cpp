#include "core/base/trial.h"

#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

namespace photond {
namespace {

/// The copy dies with this process, when its seconds are over, and when it waits for something for ever.
void limit_copy(int cpu_seconds) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const auto seconds = static_cast<rlim_t>(cpu_seconds);
  const rlimit cpu{seconds, seconds}, core{0, 0};
  setrlimit(RLIMIT_CPU, &cpu);
  setrlimit(RLIMIT_CORE, &core);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  std::signal(SIGALRM, SIG_DFL);
  alarm(10 * static_cast<unsigned>(cpu_seconds));
}

}  // namespace

bool ends_within(int cpu_seconds, const std::function<void()>& work) {
  const pid_t copy = fork();
  if (copy == 0) {
    limit_copy(cpu_seconds);
    try {
      work();
    } catch (...) {
      // It will be thrown again where it is done in earnest.
    }
    _exit(0);
  }
  int status = -1;
  while (copy > 0 && waitpid(copy, &status, 0) < 0 && errno == EINTR) {
  }
  return copy > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace photond
