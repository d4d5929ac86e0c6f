#include "server/jobs/event_log.h"

#include <algorithm>
#include <set>
#include <utility>

#include "server/jobs/job.h"
#include "server/log.h"

namespace photond {

Status EventLog::add(JobRecord& job, Event event, const Database::Body& also) {
  return note(job, store_.add_job(job, std::move(event), also));
}

Status EventLog::update(const JobRecord& job, Event event) {
  return note(job, store_.update_job(job, std::move(event)));
}

Status EventLog::remove(const std::string& job) {
  const Result<Event> stored = store_.remove_job(job);
  if (!stored) return stored.error();
  LogLine(LogLevel::info, "job").with("job", job).with("state", "gone");
  wake(*stored);
  return Done{};
}

Status EventLog::note(const JobRecord& job, const Result<Event>& stored) {
  if (!stored) return stored.error();
  if (stored->kind == EventKind::state) {
    counts_.moved(job);
    LogLine line(LogLevel::info, "job");
    line.with("job", job.id).with("state", state_name(job.state)).with("passes", job.passes);
    if (job.failure) line.with("failure", job.failure->message);
  }
  wake(*stored);
  return Done{};
}

void EventLog::wake(const Event& stored) {
  {
    const std::lock_guard lock(mutex_);
    newest_ = std::max(newest_, stored.id);
  }
  changed_.notify_all();
}

std::uint64_t EventLog::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

bool EventLog::wait_beyond(std::uint64_t seen, std::chrono::milliseconds timeout, std::stop_token stop) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, stop, timeout, [&] { return newest_ > seen; });
}

std::vector<Event> EventLog::read_after(std::uint64_t after, const std::string& job) const {
  std::vector<Event> events = store_.events_after(after, job);
  std::set<std::pair<std::string, EventKind>> seen;
  std::vector<Event> kept;
  for (auto event = events.rbegin(); event != events.rend(); ++event) {
    const bool first = seen.emplace(event->job, event->kind).second;
    if (first || event->kind == EventKind::state) kept.push_back(std::move(*event));
  }
  std::reverse(kept.begin(), kept.end());
  return kept;
}

}  // namespace photond
