#include "server/store/disk_space.h"

#include <algorithm>

#include "server/store/file.h"

namespace photond {

namespace fs = std::filesystem;

Result<DiskUse> measure_disk(const fs::path& folder, const DiskLimits& limits) {
  std::error_code failure;
  DiskUse use;
  const auto options = fs::directory_options::skip_permission_denied;
  for (auto entry = fs::recursive_directory_iterator(folder, options, failure);
       !failure && entry != fs::recursive_directory_iterator(); entry.increment(failure)) {
    std::error_code gone;  // files come and go meanwhile
    if (const std::uint64_t size = entry->is_regular_file(gone) ? entry->file_size(gone) : 0; !gone) use.used += size;
  }
  if (failure) return disk_unreachable("the data directory cannot be looked through: " + failure.message());
  const fs::space_info space = fs::space(folder, failure);
  if (failure) return disk_unreachable("the disk does not tell its space: " + failure.message());
  const std::uint64_t attainable = use.used + space.available;
  use.limit = attainable - std::min(attainable, limits.reserve_bytes);
  if (limits.quota_bytes > 0) use.limit = std::min(use.limit, limits.quota_bytes);
  return use;
}

}  // namespace photond
