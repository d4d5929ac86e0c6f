#include "server/jobs/disk_room.h"

#include <algorithm>
#include <set>

#include "server/jobs/job.h"
#include "server/store/file.h"

namespace photond {

namespace {

/// By id.
std::set<std::string> live_jobs(const Store& store) {
  std::set<std::string> ids;
  for (const JobRecord& job : store.jobs()) {
    if (!is_terminal(job.state)) ids.insert(job.id);
  }
  return ids;
}

/// Oldest first.
std::vector<JobRecord> ended_jobs(const Store& store) {
  std::vector<JobRecord> jobs = store.jobs();
  std::erase_if(jobs, [](const JobRecord& job) { return !is_terminal(job.state); });
  std::reverse(jobs.begin(), jobs.end());
  return jobs;
}

/// That no live job needs.
std::vector<SceneRecord> idle_scenes(const Store& store) {
  std::set<Digest> needed;
  for (const JobRecord& job : store.jobs()) {
    if (!is_terminal(job.state)) needed.insert(job.spec.scene);
  }
  std::vector<SceneRecord> scenes = store.scenes();
  std::erase_if(scenes, [&](const SceneRecord& scene) { return scene.sample || needed.contains(scene.id); });
  return scenes;
}

/// That no live job needs.
Result<std::vector<EnvironmentRecord>> idle_environments(const Store& store, const Environments& environments) {
  std::set<Digest> needed;
  for (const JobRecord& job : store.jobs()) {
    if (!is_terminal(job.state) && job.spec.environment) needed.insert(job.spec.environment->id);
  }
  auto idle = environments.list();
  if (idle) std::erase_if(*idle, [&](const EnvironmentRecord& record) { return needed.contains(record.id); });
  return idle;
}

template <class Record>
std::uint64_t bytes_of(const std::vector<Record>& records) {
  std::uint64_t bytes = 0;
  for (const Record& record : records) bytes += record.bytes;
  return bytes;
}

/// What left a folder since it had `before` bytes; others may be adding to it.
std::uint64_t freed(std::uint64_t before, const Blobs& files) {
  return before - std::min(before, files.total_bytes());
}

}  // namespace

DiskUse DiskRoom::use() const {
  const std::lock_guard lock(mutex_);
  return use_;
}

Status DiskRoom::measure(DiskUse& use) const {
  const Result<DiskUse> now = measure_disk(folder_, limits_);
  if (!now) return now.error();
  // Where a disk was mounted there is an empty folder.
  if (const Status there = files_.checkpoint_files().look(); !there) return there;
  use = *now;
  return Done{};
}

Status DiskRoom::make_room(std::uint64_t bytes, const std::string& job) {
  const std::lock_guard lock(mutex_);
  DiskUse use;
  if (const Status measured = measure(use); !measured) return measured;
  if (use.has_room(bytes)) return Done{};
  const Result<std::uint64_t> spare = spare_bytes();
  if (!spare) return spare.error();
  // What is removed in vain is missed for nothing.
  if (use.without(*spare).has_room(bytes)) {
    const std::uint64_t target = use.limit - std::min(use.limit, bytes);
    if (const Status reduced = reduce_to(target, use); !reduced) return reduced;
    if (const Status dropped = drop_older_checkpoints(target, use, job); !dropped) return dropped;
  }
  if (use.has_room(bytes)) return Done{};
  return disk_full("the disk is full: " + std::to_string(bytes) + " more bytes are needed, and " +
                   std::to_string(use.used) + " of " + std::to_string(use.limit) + " are in use");
}

Status DiskRoom::tidy() {
  const Status tidied = look_and_tidy();
  found_.change([&](Status& found) { found = tidied; });
  return tidied;
}

Status DiskRoom::look_and_tidy() {
  const std::lock_guard lock(mutex_);
  if (const Status measured = measure(use_); !measured) return measured;
  if (use_.used > use_.high_water()) {
    if (const Status reduced = reduce_to(use_.low_water(), use_); !reduced) return reduced;
    if (const Status dropped = drop_older_checkpoints(use_.high_water(), use_, {}); !dropped) return dropped;
  }
  // Two marks, so that it does not become full again with the next byte.
  full_ = full_ ? use_.used > use_.high_water() : !use_.has_room(1);
  return Done{};
}

/// Of all that may be removed.
Result<std::uint64_t> DiskRoom::spare_bytes() const {
  const Result<std::uint64_t> files = files_.spare_bytes(live_jobs(store_));
  if (!files) return files.error();
  const auto environments = idle_environments(store_, environments_);
  if (!environments) return environments.error();
  const std::uint64_t maps = maps_.bytes ? maps_.bytes() : 0;
  return maps + *files + bytes_of(idle_scenes(store_)) + bytes_of(*environments);
}

Status DiskRoom::reduce_to(std::uint64_t target, DiskUse& use) {
  if (maps_.free && use.used > target) {
    maps_.free(use.used - target);
    if (const Status measured = measure(use); !measured) return measured;
  }
  if (const Status dropped = drop_checkpoints(target, use); !dropped) return dropped;
  if (const Status dropped = drop_frames(target, use); !dropped) return dropped;
  if (const Status dropped = drop_scenes(target, use); !dropped) return dropped;
  return drop_environments(target, use);
}

Status DiskRoom::drop_checkpoints(std::uint64_t target, DiskUse& use) {
  for (const JobRecord& job : ended_jobs(store_)) {
    if (use.used <= target) return Done{};
    const std::uint64_t before = files_.checkpoint_files().total_bytes();
    if (const Status dropped = files_.drop_checkpoints(job.id); !dropped) return dropped;
    use.used -= std::min(use.used, freed(before, files_.checkpoint_files()));
  }
  return Done{};
}

Status DiskRoom::drop_older_checkpoints(std::uint64_t target, DiskUse& use, const std::string& first) {
  std::vector<std::string> jobs{first};
  for (const std::string& job : live_jobs(store_)) jobs.push_back(job);
  for (const std::string& job : jobs) {
    if (use.used <= target) return Done{};
    const std::uint64_t before = files_.checkpoint_files().total_bytes();
    if (const Status dropped = files_.drop_older_checkpoints(job); !dropped) return dropped;
    use.used -= std::min(use.used, freed(before, files_.checkpoint_files()));
  }
  return Done{};
}

Status DiskRoom::drop_frames(std::uint64_t target, DiskUse& use) {
  for (const JobRecord& job : ended_jobs(store_)) {
    if (use.used <= target) return Done{};
    const std::uint64_t before = files_.frame_files().total_bytes();
    if (const Status dropped = files_.drop_frames(job.id); !dropped) return dropped;
    use.used -= std::min(use.used, freed(before, files_.frame_files()));
  }
  return Done{};
}

Status DiskRoom::drop_scenes(std::uint64_t target, DiskUse& use) {
  for (const SceneRecord& scene : idle_scenes(store_)) {
    if (use.used <= target) return Done{};
    if (const Status removed = store_.remove_scene(scene.id); !removed) return removed;
    use.used -= std::min(use.used, scene.bytes);
  }
  return Done{};
}

Status DiskRoom::drop_environments(std::uint64_t target, DiskUse& use) {
  if (use.used <= target) return Done{};
  const auto environments = idle_environments(store_, environments_);
  if (!environments) return environments.error();
  for (const EnvironmentRecord& environment : *environments) {
    if (use.used <= target) return Done{};
    if (const Status removed = environments_.remove(environment.id); !removed) return removed;
    use.used -= std::min(use.used, environment.bytes);
  }
  return Done{};
}

}  // namespace photond
