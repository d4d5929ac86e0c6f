#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "core/base/sections.h"
#include "core/photon/map_bytes.h"

namespace photond {

/// Files of photon maps and guides in a folder of their own, within a budget of bytes: the least recently used give
/// way, pinned ones stay. There is nothing beside the files: a name tells the key and whether it is pinned, the time of
/// modification the last use. So whenever the process ends, what is found again is right, and what a crash cuts short
/// has the name of a temporary file. What is in the files is the core's (map_bytes). Thread-safe.
class MapFiles {
 public:
  struct Info {
    MapKey key;
    std::uint64_t bytes = 0;
    MapFacts facts;
    std::chrono::system_clock::time_point last_use;
    bool pinned = false;
    std::uint64_t hits = 0;   ///< since the start
  };
  struct Totals {
    std::uint64_t bytes = 0;
    std::uint64_t entries = 0;
    std::uint64_t evictions = 0;   ///< for room
  };

  /// Makes the folder where it is missing, removes temporary files and those of other photon stages, and lists the
  /// others, down to the budget. Errors: system_error.
  static Result<std::unique_ptr<MapFiles>> open(const std::filesystem::path& folder, std::uint64_t budget_bytes);

  /// The file, mapped into memory; notes the use. Nothing where there is none or it cannot be mapped.
  std::optional<SharedSpan> map(const MapKey& key);
  /// Writes a file: temporary, fsync, rename, fsync of the folder. Makes room first; what has no room beside what is
  /// pinned is not written, which is no error. Errors: system_error.
  Status put(const MapKey& key, const MapFacts& facts, std::span<const std::span<const std::byte>> pieces);
  /// False where there is none.
  bool erase(const MapKey& key);
  /// Keeps a file whatever the budget, or no longer; durable. False where there is none or it cannot be renamed.
  bool pin(const MapKey& key, bool pinned);
  /// Removes the least recently used that are not pinned until `bytes` are free or none are left; returns how many
  /// bytes it freed. For whoever needs the disk for something that cannot be made again.
  std::uint64_t evict(std::uint64_t bytes);
  /// As many as `evict` can free.
  std::uint64_t evictable_bytes() const;

  std::optional<Info> find(const MapKey& key) const;
  /// In the order of the keys.
  std::vector<Info> list() const;
  Totals totals() const;
  std::uint64_t budget_bytes() const { return budget_bytes_; }

 private:
  using Entries = std::map<MapKey, Info>;

  MapFiles(std::filesystem::path folder, std::uint64_t budget_bytes)
      : folder_(std::move(folder)), budget_bytes_(budget_bytes) {}

  Status scan();
  void make_room(std::uint64_t bytes);
  bool evict_oldest();
  void remove(Entries::iterator entry);
  std::filesystem::path path_of(const Info& info) const;

  const std::filesystem::path folder_;
  const std::uint64_t budget_bytes_;
  mutable std::mutex mutex_;
  Entries entries_;
  std::uint64_t bytes_ = 0;
  std::uint64_t evictions_ = 0;
  std::atomic<std::uint64_t> next_temporary_{0};
};

}  // namespace photond
