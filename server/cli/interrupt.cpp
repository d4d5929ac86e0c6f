#include "server/cli/interrupt.h"

#include <pthread.h>
#include <unistd.h>

#include <chrono>
#include <csignal>

#include "server/cli/files.h"

namespace photond {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kSameWish{200};  // from the first signal on

sigset_t watched_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  struct sigaction hangup {};
  ::sigaction(SIGHUP, nullptr, &hangup);
  if (hangup.sa_handler != SIG_IGN) sigaddset(&set, SIGHUP);
  return set;
}

}  // namespace

Interrupt::Interrupt(Ends ends) : ends_(ends) {
  const sigset_t set = watched_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  thread_ = std::thread([this] { watch(); });
}

Interrupt::~Interrupt() {
  done_ = true;
  pthread_kill(thread_.native_handle(), SIGTERM);  // wakes sigwait
  thread_.join();
}

void Interrupt::wait() const { signal_.wait(0); }

void Interrupt::watch() {
  const sigset_t set = watched_signals();
  int signal = 0;
  Clock::time_point first{};
  while (sigwait(&set, &signal) == 0 && !done_) {
    if (signal_ != 0 && Clock::now() - first < kSameWish) continue;
    if (signal_ != 0 || ends_ == Ends::at_first) {
      drop_unfinished_file();
      _exit(128 + signal);
    }
    first = Clock::now();
    signal_ = signal;
    signal_.notify_all();
    source_.request_stop();
  }
}

}  // namespace photond
