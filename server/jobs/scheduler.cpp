#include "server/jobs/scheduler.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace photond {

void Scheduler::Class::fill(Memory& memory) {
  const auto let_in = [&](std::shared_ptr<Slices>& work) {
    memory.take(*work);
    active.push_back(std::move(work));
  };
  while (active.size() < kMaxActive && !waiting.empty() && memory.fits(*waiting.front())) {
    let_in(waiting.front());
    waiting.pop_front();
  }
  for (auto work = waiting.begin(); work != waiting.end();) {
    if (serves((*work)->owner()) || !memory.fits(**work)) {
      ++work;
    } else {
      let_in(*work);
      work = waiting.erase(work);
    }
  }
}

/// While an owner's only active work has its turn, which it has outside of the list, one more may come in.
bool Scheduler::Class::serves(const std::string& owner) const {
  return std::any_of(active.begin(), active.end(), [&](const auto& work) { return work->owner() == owner; });
}

/// The first, or else what its owner would rather see: then the first has had its turn as well.
std::shared_ptr<Slices> Scheduler::Class::take_next() {
  const auto first = std::move(active.front());
  active.pop_front();
  const std::string owner = first->owner();
  const auto preferred = std::find_if(active.begin(), active.end(), [&](const auto& work) {
    return work->unseen() && work->owner() == owner;
  });
  if (first->unseen() || preferred == active.end()) return first;
  const auto work = std::move(*preferred);
  active.erase(preferred);
  active.push_back(first);
  return work;
}

Scheduler::Scheduler(std::uint64_t most_memory) : memory_{most_memory}, thread_([this] { run(); }) {}

Scheduler::~Scheduler() { stop(); }

void Scheduler::submit(std::shared_ptr<Slices> work, Priority priority) {
  {
    const std::lock_guard lock(mutex_);
    classes_[static_cast<int>(priority)].waiting.push_back(std::move(work));
    fill();
  }
  work_.notify_one();
}

void Scheduler::fill() {
  for (Class& each : classes_) each.fill(memory_);
}

/// What waited counts among what takes turns from now on.
bool Scheduler::take_out(Class& from, const std::shared_ptr<Slices>& work) {
  if (std::erase(from.waiting, work) > 0) {
    memory_.take(*work);
    return true;
  }
  return std::erase(from.active, work) > 0;
}

bool Scheduler::hurry(const std::shared_ptr<Slices>& work) {
  const std::lock_guard lock(mutex_);
  for (int priority = 0; priority < 2; ++priority) {
    if (!take_out(classes_[priority], work)) continue;
    hurried_.push_back({work, static_cast<Priority>(priority)});
    fill();
    return true;
  }
  return std::any_of(hurried_.begin(), hurried_.end(), [&](const Hurried& h) { return h.work == work; });
}

bool Scheduler::wait_idle(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  return idle_.wait_for(lock, timeout, [&] { return !busy_ && !has_work(); });
}

bool Scheduler::has_work() const {
  return !hurried_.empty() || !classes_[0].active.empty() || !classes_[1].active.empty();
}

void Scheduler::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  work_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::shared_ptr<Slices> Scheduler::take(Priority& priority) {
  std::unique_lock lock(mutex_);
  work_.wait(lock, [&] { return stopping_ || has_work(); });
  if (stopping_) return nullptr;
  busy_ = true;
  if (!hurried_.empty()) {
    Hurried next = std::move(hurried_.front());
    hurried_.pop_front();
    priority = next.priority;
    return std::move(next.work);
  }
  priority = classes_[0].active.empty() ? Priority::batch : Priority::interactive;
  return classes_[static_cast<int>(priority)].take_next();
}

void Scheduler::run() {
  // Without this the HTTP threads wait for a time slice whenever all cores render.
  lower_priority();
  Priority priority{};
  while (std::shared_ptr<Slices> work = take(priority)) {
    const bool more = work->step();
    const std::lock_guard lock(mutex_);
    if (more) {
      classes_[static_cast<int>(priority)].active.push_back(std::move(work));
    } else {
      memory_.give_back(*work);
    }
    fill();
    busy_ = false;
    idle_.notify_all();
  }
}

}  // namespace photond
