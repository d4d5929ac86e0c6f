#include "server/jobs/disk_room.h"

#include <algorithm>
#include <set>

#include "server/jobs/job.h"
#include "server/store/file.h"

namespace photond {

namespace {

/// Oldest first.
std::vector<JobRecord> ended_jobs(const Store& store) {
  std::vector<JobRecord> jobs = store.jobs();
  std::erase_if(jobs, [](const JobRecord& job) { return !is_terminal(job.state); });
  std::reverse(jobs.begin(), jobs.end());
  return jobs;
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
  use = *now;
  return Done{};
}

Status DiskRoom::make_room(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  DiskUse use;
  if (const Status measured = measure(use); !measured) return measured;
  if (!use.has_room(bytes)) {
    if (const Status reduced = reduce_to(use.limit - std::min(use.limit, bytes), use); !reduced) return reduced;
  }
  if (use.has_room(bytes)) return Done{};
  return disk_full("the disk is full: " + std::to_string(bytes) + " more bytes are needed, and " +
                   std::to_string(use.used) + " of " + std::to_string(use.limit) + " are in use");
}

Status DiskRoom::tidy() {
  const std::lock_guard lock(mutex_);
  if (const Status measured = measure(use_); !measured) return measured;
  if (use_.used > use_.high_water()) {
    if (const Status reduced = reduce_to(use_.low_water(), use_); !reduced) return reduced;
  }
  // Two marks, so that it does not become full again with the next byte.
  full_ = full_ ? use_.used > use_.high_water() : !use_.has_room(1);
  return Done{};
}

Status DiskRoom::reduce_to(std::uint64_t target, DiskUse& use) {
  if (evict_maps_ && use.used > target) {
    evict_maps_(use.used - target);
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
  std::set<Digest> needed;
  for (const JobRecord& job : store_.jobs()) {
    if (!is_terminal(job.state)) needed.insert(job.spec.scene);
  }
  for (const SceneRecord& scene : store_.scenes()) {
    if (use.used <= target) return Done{};
    if (scene.sample || needed.contains(scene.id)) continue;
    if (const Status removed = store_.remove_scene(scene.id); !removed) return removed;
    use.used -= std::min(use.used, scene.bytes);
  }
  return Done{};
}

Status DiskRoom::drop_environments(std::uint64_t target, DiskUse& use) {
  if (use.used <= target) return Done{};
  std::set<Digest> needed;
  for (const JobRecord& job : store_.jobs()) {
    if (!is_terminal(job.state) && job.spec.environment) needed.insert(job.spec.environment->id);
  }
  const auto environments = environments_.list();
  if (!environments) return environments.error();
  for (const EnvironmentRecord& environment : *environments) {
    if (use.used <= target) return Done{};
    if (needed.contains(environment.id)) continue;
    if (const Status removed = environments_.remove(environment.id); !removed) return removed;
    use.used -= std::min(use.used, environment.bytes);
  }
  return Done{};
}

}  // namespace photond
