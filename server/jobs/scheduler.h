#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "server/store/records.h"

namespace photond {

/// Work that is done in slices; knows nothing of threads.
class Slices {
 public:
  virtual ~Slices() = default;
  /// Does the next slice; false when nothing is left.
  virtual bool step() = 0;
  /// For whom it is done; always the same.
  virtual std::string owner() const { return {}; }
  /// Whether nobody can see anything of it yet. Asked between slices.
  virtual bool unseen() const { return false; }
  /// Bytes that it may hold from its first slice on until nothing is left; always the same.
  virtual std::uint64_t memory() const { return 0; }
};

/// Gives the render thread to the waiting work slice by slice: interactive before batch, round robin inside a
/// class, so that jobs share the machine by passes. At most `kMaxActive` of a class take turns, in the order they
/// came, and of both classes together no more than there is memory for; the rest wait. Who has none among them need not
/// wait for the others' turns, only for memory: his first is let in beside them. What nobody can see anything of yet
/// has the turns of its owner's other work: a first picture soon is worth more than a better one a little sooner. Knows
/// nothing of rendering.
class Scheduler {
 public:
  static constexpr std::size_t kMaxActive = 8;

  /// `most_memory`: of all work that takes turns, in bytes. What needs more takes its turns alone.
  explicit Scheduler(std::uint64_t most_memory);
  ~Scheduler();
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  void submit(std::shared_ptr<Slices> work, Priority priority);
  /// Gives the next turn to queued work, before all other. False where its slice is running at this moment or it is
  /// not queued: then a running slice must be told to stop by other means.
  bool hurry(const std::shared_ptr<Slices>& work);
  /// Waits until nothing is queued or running; false after `timeout`.
  bool wait_idle(std::chrono::milliseconds timeout);
  /// Ends the thread after the running slice; what is queued stays undone.
  void stop();

 private:
  // What the work holds that takes turns: is active, hurried or running.
  struct Memory {
    std::uint64_t most;
    std::uint64_t held = 0;
    bool fits(const Slices& work) const { return held == 0 || held + work.memory() <= most; }
    void take(const Slices& work) { held += work.memory(); }
    void give_back(const Slices& work) { held -= work.memory(); }
  };
  struct Class {
    std::deque<std::shared_ptr<Slices>> active;
    std::deque<std::shared_ptr<Slices>> waiting;
    void fill(Memory& memory);
    bool serves(const std::string& owner) const;
    std::shared_ptr<Slices> take_next();
  };
  struct Hurried {
    std::shared_ptr<Slices> work;
    Priority priority;  ///< its class, if it goes on
  };
  void run();
  std::shared_ptr<Slices> take(Priority& priority);
  bool has_work() const;
  void fill();
  bool take_out(Class& from, const std::shared_ptr<Slices>& work);

  std::mutex mutex_;
  std::condition_variable work_;
  std::condition_variable idle_;
  std::deque<Hurried> hurried_;
  bool busy_ = false;  ///< a slice is running
  Class classes_[2];  ///< by Priority
  Memory memory_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace photond
