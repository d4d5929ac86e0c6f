#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "core/photon/map_bytes.h"
#include "server/jobs/shared_cache.h"
#include "server/store/map_files.h"

namespace photond {

/// What a MapKey names: the photon maps of a pass, or the guide of a scene.
struct CachedMap {
  std::shared_ptr<const PhotonMaps> maps;    ///< null where the key is a guide's
  std::shared_ptr<const GatherGuide> guide;  ///< null where it is not
  MapFacts facts;
  std::uint64_t memory_bytes = 0;
};

/// Photon maps and guides shared by all jobs, in memory and on disk; a MapKey holds no camera, size or radius. What is
/// asked for is looked for in memory, then on disk, then built, once however many ask; what was built and is kept is
/// written to disk by a thread of its own. Thread-safe.
class MapCache {
 public:
  enum class Origin : std::uint8_t { memory, disk, built };
  struct Answer {
    std::shared_ptr<const CachedMap> value;
    Origin origin = Origin::built;
  };
  struct Info {
    MapKey key;
    std::uint64_t bytes = 0;  ///< in memory, otherwise of the file
    MapFacts facts;
    std::uint64_t hits = 0;  ///< since the start, in memory since it came there
    std::chrono::system_clock::time_point last_use;
    bool in_memory = false;
    bool on_disk = false;
    bool pinned = false;
  };
  struct Totals {
    SharedCache<MapKey, CachedMap>::Totals memory;
    MapFiles::Totals disk;
    std::uint64_t disk_hits = 0;
    std::uint64_t misses = 0;  ///< in both tiers
    std::uint64_t write_failures = 0;
    std::uint64_t damaged = 0;  ///< files that were found damaged, and removed
  };

  /// `files` may be null: no disk tier.
  MapCache(std::uint64_t memory_bytes, std::unique_ptr<MapFiles> files);
  /// Goes on writing for a while; what is not on disk by then is dropped.
  ~MapCache();

  /// With `keep` false what is built here is neither stored nor written. Errors: cancelled, those of building.
  Result<Answer> get(const PreparedScene& scene, const MapKey& key, const Execution& execution, bool keep);

  std::vector<Info> list() const;
  std::optional<Info> find(const MapKey& key) const;
  Totals totals() const;
  std::uint64_t memory_budget() const { return memory_.budget_bytes(); }
  std::uint64_t disk_budget() const { return files_ ? files_->budget_bytes() : 0; }

  /// Forgets it in memory and on disk; false where it is in neither.
  bool erase(const MapKey& key);
  /// Keeps it from eviction in both tiers, or no longer. Errors: not_found; conflict where more than half of a budget
  /// would be pinned.
  Status pin(const MapKey& key, bool pinned);
  /// Bytes of disk that `free_disk` can free.
  std::uint64_t spare_disk() const { return files_ ? files_->evictable_bytes() : 0; }
  /// Frees at least so many bytes of disk, or all that is not pinned; returns how many.
  std::uint64_t free_disk(std::uint64_t bytes) { return files_ ? files_->evict(bytes) : 0; }
  /// Waits until what was built so far is on disk; false where that takes longer.
  bool flush(std::chrono::milliseconds patience = std::chrono::minutes(1));

 private:
  using Memory = SharedCache<MapKey, CachedMap>;
  struct Write {
    MapKey key;
    Memory::Shared value;
  };

  Result<Memory::Shared> build(const PreparedScene& scene, const MapKey& key, const Execution& execution);
  Result<std::shared_ptr<const PhotonMaps>> build_maps(const PreparedScene& scene, const MapKey& key,
                                                       const Execution& execution);
  Memory::Shared read(const MapKey& key, const Execution& execution);
  void write_later(const MapKey& key, Memory::Shared value);
  void write_all(std::stop_token stop);
  bool write(const Write& what);

  const std::unique_ptr<MapFiles> files_;
  Memory memory_;
  std::atomic<std::uint64_t> disk_hits_{0};
  std::atomic<std::uint64_t> write_failures_{0};
  std::atomic<std::uint64_t> damaged_{0};

  std::mutex mutex_;  ///< guards what follows
  std::condition_variable_any changed_;
  std::deque<Write> queue_;
  std::uint64_t queued_bytes_ = 0;
  std::optional<MapKey> writing_;
  bool unwanted_ = false;  ///< what is being written was erased meanwhile
  std::jthread writer_;    ///< last: uses all of the above
};

/// One job's use of the cache. A progressive job asks for a new map in every pass, which would flush the maps
/// of everybody else: so each job may keep only its first passes, up to a quarter of the budget. What is in
/// the cache already it may always use; what it builds later is dropped after the pass.
class MapUse {
 public:
  explicit MapUse(MapCache& cache) : cache_(cache) {}

  /// The maps of `key`, counted as a hit or a miss; those asked for last are handed out again without counting.
  Result<std::shared_ptr<const PhotonMaps>> maps(const PreparedScene& scene, const MapKey& key,
                                                 const Execution& execution);
  Result<std::shared_ptr<const GatherGuide>> guide(const PreparedScene& scene, const MapKey& key,
                                                   const Execution& execution);
  /// Lets go of the maps asked for last.
  void release() { last_.reset(); }

  void count_anew() { hits_ = disk_hits_ = misses_ = 0; }
  std::uint64_t hits() const { return hits_; }  ///< in memory or on disk
  std::uint64_t disk_hits() const { return disk_hits_; }
  std::uint64_t misses() const { return misses_; }

 private:
  Result<std::shared_ptr<const CachedMap>> get(const PreparedScene& scene, const MapKey& key,
                                               const Execution& execution);

  MapCache& cache_;
  std::optional<std::pair<MapKey, std::shared_ptr<const PhotonMaps>>> last_;
  std::uint64_t kept_bytes_ = 0;
  std::uint64_t hits_ = 0;
  std::uint64_t disk_hits_ = 0;
  std::uint64_t misses_ = 0;
};

}  // namespace photond
