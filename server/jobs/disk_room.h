#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>

#include "server/jobs/guarded.h"
#include "server/store/disk_space.h"
#include "server/store/environments.h"
#include "server/store/job_files.h"
#include "server/store/store.h"

namespace photond {

/// Keeps the data directory within its limits, by removing what can be made again or missed, in this order: photon
/// maps; checkpoints of ended jobs; pictures of ended jobs, the oldest first; scenes, then environments, that no job
/// needs which has not ended; of jobs that have not ended, checkpoints before the newest. Thread-safe.
class DiskRoom {
 public:
  /// Photon maps, as far as it goes for room.
  struct Maps {
    std::function<std::uint64_t()> bytes;                    ///< of files that may go
    std::function<std::uint64_t(std::uint64_t bytes)> free;  ///< removes so many, if there are; returns how many
  };

  /// The references must outlive the object.
  DiskRoom(std::filesystem::path folder, const DiskLimits& limits, Store& store, Environments& environments,
           JobFiles& files)
      : folder_(std::move(folder)), limits_(limits), store_(store), environments_(environments), files_(files) {}

  /// There are none at first.
  void set_maps(Maps maps) { maps_ = std::move(maps); }

  /// Makes room for a file, of this job where one is named: then its own older checkpoint goes before those of others.
  /// Errors: limit_exceeded at "disk" where that cannot be: then nothing was removed; disk_unreachable; io.
  Status make_room(std::uint64_t bytes, const std::string& job = {});
  /// To be called now and then: above the high water mark removes down to the low one, and finds out whether the disk
  /// is full. Errors: disk_unreachable, io.
  Status tidy();
  /// Nothing is removed while this is held: what a job needs that begins meanwhile stays.
  std::unique_lock<std::mutex> hold() const { return std::unique_lock(mutex_); }
  /// By the last `tidy`: there is no room, and no more can be made. Ends below the high water mark.
  bool full() const { return full_; }
  /// What the last `tidy` has found: where it failed the folder is as good as full. Errors: its.
  Status found() const { return found_.get(); }
  /// How much is in use, when that could last be told.
  DiskUse use() const;

 private:
  Status look_and_tidy();
  Result<std::uint64_t> spare_bytes() const;
  Status reduce_to(std::uint64_t bytes, DiskUse& use);
  Status drop_older_checkpoints(std::uint64_t target, DiskUse& use, const std::string& first);
  Status drop_checkpoints(std::uint64_t target, DiskUse& use);
  Status drop_frames(std::uint64_t target, DiskUse& use);
  Status drop_scenes(std::uint64_t target, DiskUse& use);
  Status drop_environments(std::uint64_t target, DiskUse& use);
  Status measure(DiskUse& use) const;

  const std::filesystem::path folder_;
  const DiskLimits limits_;
  Store& store_;
  Environments& environments_;
  JobFiles& files_;
  Maps maps_;
  mutable std::mutex mutex_;
  DiskUse use_;  ///< by the last `tidy`
  std::atomic<bool> full_{false};
  Guarded<Status> found_{Done{}};
};

}  // namespace photond
