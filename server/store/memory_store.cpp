#include "server/store/memory_store.h"

#include <algorithm>

namespace photond {

namespace {

constexpr std::size_t kEventsPerJob = 256;  // state events beyond it stay: there are at most eight of them

void trim(std::deque<Event>& events) {
  if (events.size() <= kEventsPerJob) return;
  const auto passing =
      std::find_if(events.begin(), events.end(), [](const Event& e) { return e.kind != EventKind::state; });
  if (passing != events.end()) events.erase(passing);
}

}  // namespace

Status MemoryStore::put_scene(const SceneRecord& scene, Blob bytes) {
  const std::lock_guard lock(mutex_);
  if (scenes_.contains(scene.id)) return Done{};
  if (!scene.sample && scene_bytes_total_ + scene.bytes > scene_budget_bytes_) {
    return Error{
        ErrorCode::limit_exceeded,
        "the scene store is full (" + std::to_string(scene_budget_bytes_) + " bytes); delete scenes first", ""};
  }
  if (!scene.sample) scene_bytes_total_ += scene.bytes;
  scenes_.emplace(scene.id, StoredScene{scene, std::move(bytes), next_order_++});
  return Done{};
}

std::optional<SceneRecord> MemoryStore::scene(const Digest& id) const {
  const std::lock_guard lock(mutex_);
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) return std::nullopt;
  return found->second.record;
}

Blob MemoryStore::scene_bytes(const Digest& id) const {
  const std::lock_guard lock(mutex_);
  const auto found = scenes_.find(id);
  return found == scenes_.end() ? nullptr : found->second.bytes;
}

std::vector<SceneRecord> MemoryStore::scenes() const {
  const std::lock_guard lock(mutex_);
  std::vector<const StoredScene*> ordered;
  for (const auto& [id, scene] : scenes_) ordered.push_back(&scene);
  std::sort(ordered.begin(), ordered.end(), [](const StoredScene* a, const StoredScene* b) {
    return std::pair(!a->record.sample, a->order) < std::pair(!b->record.sample, b->order);
  });
  std::vector<SceneRecord> records;
  for (const StoredScene* scene : ordered) records.push_back(scene->record);
  return records;
}

bool MemoryStore::remove_scene(const Digest& id) {
  const std::lock_guard lock(mutex_);
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) return false;
  if (!found->second.record.sample) scene_bytes_total_ -= found->second.record.bytes;
  scenes_.erase(found);
  return true;
}

Event MemoryStore::append(StoredJob& job, Event event) {
  event.id = next_event_++;
  job.events.push_back(event);
  trim(job.events);
  return event;
}

Result<Event> MemoryStore::add_job(JobRecord& job, Event event) {
  const std::lock_guard lock(mutex_);
  if (jobs_.contains(job.id)) return Error{ErrorCode::conflict, "a job of this id exists", ""};
  job.sequence = next_sequence_++;
  StoredJob& stored = jobs_[job.id];
  stored.record = job;
  return append(stored, std::move(event));
}

Result<Event> MemoryStore::update_job(const JobRecord& job, Event event) {
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(job.id);
  if (found == jobs_.end()) return Error{ErrorCode::not_found, "there is no job " + job.id, ""};
  found->second.record = job;
  return append(found->second, std::move(event));
}

std::optional<JobRecord> MemoryStore::job(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return std::nullopt;
  return found->second.record;
}

std::vector<JobRecord> MemoryStore::jobs() const {
  const std::lock_guard lock(mutex_);
  std::vector<JobRecord> records;
  for (const auto& [id, job] : jobs_) records.push_back(job.record);
  std::sort(records.begin(), records.end(),
            [](const JobRecord& a, const JobRecord& b) { return a.sequence > b.sequence; });
  return records;
}

bool MemoryStore::remove_job(const std::string& id) {
  const std::lock_guard lock(mutex_);
  return jobs_.erase(id) > 0;
}

std::vector<Event> MemoryStore::events_after(std::uint64_t after, const std::string& job) const {
  const std::lock_guard lock(mutex_);
  std::vector<Event> events;
  const auto collect = [&](const StoredJob& stored) {
    std::copy_if(stored.events.begin(), stored.events.end(), std::back_inserter(events),
                 [after](const Event& e) { return e.id > after; });
  };
  if (!job.empty()) {
    const auto found = jobs_.find(job);
    if (found != jobs_.end()) collect(found->second);
    return events;
  }
  for (const auto& [id, stored] : jobs_) collect(stored);
  std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.id < b.id; });
  return events;
}

}  // namespace photond
