#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace photond {

/// Threads for requests: as many as there are requests at once, up to a limit; an idle one takes the next.
class Crew {
 public:
  explicit Crew(std::size_t limit) : limit_(limit) {}
  ~Crew() { stop(); }
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  /// Runs `task`, which must throw nothing, on a thread of its own. False where all threads are taken.
  bool start(std::function<void()> task);
  /// Waits for the running tasks and ends the threads; nothing starts any more.
  void stop();

 private:
  void work();

  const std::size_t limit_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;
  std::vector<std::thread> threads_;
  std::size_t idle_ = 0;
  bool stopping_ = false;
};

}  // namespace photond
