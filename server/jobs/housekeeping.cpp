// What jobs leave behind, and what waits for room.
#include <algorithm>
#include <exception>

#include "server/jobs/jobs.h"
#include "server/log.h"

namespace photond {

namespace {

/// What is paused by request meanwhile no longer does.
Status waits_for_disk(const JobRecord& job) {
  if (is_by_disk(job.pause_reason)) return Done{};
  return Error{ErrorCode::conflict, "the job does not wait for the disk", ""};
}

void tell(const Status& found) {
  if (found) {
    LogLine(LogLevel::info, "disk_reachable");
  } else {
    LogLine(LogLevel::warning, "disk_unreachable").with("why", found.error().message);
  }
}

}  // namespace

/// The files go first: a job whose files are missing is whole, a file whose job is missing is litter.
Status Jobs::forget(const std::string& id) {
  if (const Status dropped = files_.drop_checkpoints(id); !dropped) return dropped;
  if (const Status dropped = files_.drop_frames(id); !dropped) return dropped;
  if (const Status removed = log_.remove(id); !removed) return removed;
  runs_.erase(id);
  return Done{};
}

Status Jobs::forget_oldest() {
  std::vector<std::pair<std::uint64_t, std::string>> ended;
  for (const auto& [id, run] : runs_) {
    const JobRecord record = run->job()->record();
    if (is_terminal(record.state)) ended.emplace_back(record.sequence, id);
  }
  if (ended.size() <= static_cast<std::size_t>(limits_.max_kept_jobs)) return Done{};
  std::sort(ended.begin(), ended.end());
  ended.resize(ended.size() - static_cast<std::size_t>(limits_.max_kept_jobs));
  for (const auto& [sequence, id] : ended) {
    if (const Status forgotten = forget(id); !forgotten) return forgotten;
  }
  return Done{};
}

/// Looks after the disk, and after jobs that wait for it.
void Jobs::keep_house(std::stop_token stop) {
  constexpr std::chrono::seconds kInterval{1};
  std::mutex mutex;
  while (!stop.stop_requested()) {
    try {
      tidy_up();
    } catch (const std::exception&) {  // out of memory: it is done by the next round
    }
    std::unique_lock lock(mutex);
    tick_.wait_for(lock, stop, kInterval, [] { return false; });
  }
}

void Jobs::tidy_up() {
  const bool was_found = room_.found().ok();
  const Status found = room_.tidy();
  if (found.ok() != was_found) tell(found);
  // A disk that cannot be looked at is as good as a full one.
  if (!found)
    pause_for(PauseReason::disk_unreachable);
  else if (room_.full())
    pause_for(PauseReason::disk_full);
  else
    wake();
  count_without_room();
}

void Jobs::pause_for(PauseReason reason) {
  const std::lock_guard lock(mutex_);
  for (const auto& [id, run] : runs_) {
    const JobState state = run->job()->state();
    if (state != JobState::queued && !is_running(state)) continue;
    const Status paused =
        run->job()->move(JobState::paused, [reason](JobRecord& record) { record.pause_reason = reason; });
    if (!paused) continue;  // it has moved on, or nothing can be written at all: then its run stalls
    run->interrupt();
    scheduler_.hurry(run);
  }
}

/// Takes up what waited for the disk, in the order it came; what rests in memory only is put away. Where all jobs wait,
/// the first goes on without room: once it has ended, what it has may go.
void Jobs::wake() {
  const std::lock_guard lock(mutex_);
  if (stopping_) return;
  std::map<std::uint64_t, std::shared_ptr<RunJob>> waiting;
  bool all_wait = true;
  for (const auto& [id, run] : runs_) {
    const JobState state = run->job()->state();
    const bool paused = is_by_disk(run->job()->pause_reason());
    if (paused || run->stalled() || run->unsaved()) waiting.emplace(run->job()->record().sequence, run);
    if (state == JobState::queued || is_running(state)) all_wait = false;
  }
  for (const auto& [sequence, run] : waiting) {
    const bool has_room = run->missing_bytes() == 0 || room_.make_room(run->missing_bytes(), run->job()->id).ok();
    if (!has_room && !(all_wait && waits_for_disk(run->job()->record()).ok())) continue;
    if (!has_room) run->dare();
    const bool goes_on = run->job()->move(JobState::queued, {}, waits_for_disk).ok();
    if (goes_on || run->stalled() || run->unsaved()) put_to_work(run);
    if (goes_on) all_wait = false;
  }
}

void Jobs::count_without_room() {
  const std::lock_guard lock(mutex_);
  without_room_ = static_cast<int>(std::count_if(runs_.begin(), runs_.end(), [](const auto& entry) {
    const RunJob& run = *entry.second;
    return run.missing_bytes() > 0 || run.job()->pause_reason() == PauseReason::disk_full;
  }));
}

}  // namespace photond
