#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>

#include "core/base/result.h"

namespace photond {

/// What a data directory may take.
struct DiskLimits {
  std::uint64_t quota_bytes = 20ull << 30;    ///< 0: none
  std::uint64_t reserve_bytes = 64ull << 20;  ///< of the file system, left free: the database needs a little to say more
};

/// How full a data directory is.
struct DiskUse {
  std::uint64_t used = 0;
  std::uint64_t limit = 0;  ///< by the quota or the file system, whichever is less

  /// Above it what can be missed is removed, until the low one is reached.
  std::uint64_t high_water() const { return limit / 100 * 90; }
  std::uint64_t low_water() const { return limit / 100 * 75; }
  bool has_room(std::uint64_t bytes) const { return used + bytes <= limit; }
  /// As it would be after so many bytes were removed.
  DiskUse without(std::uint64_t bytes) const { return {used - std::min(used, bytes), limit}; }
};

/// Looks through the folder and asks the file system. Errors: disk_unreachable.
Result<DiskUse> measure_disk(const std::filesystem::path& folder, const DiskLimits& limits);

}  // namespace photond
