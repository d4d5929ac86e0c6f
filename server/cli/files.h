#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "core/base/result.h"

namespace photond {

/// The bytes of a regular file. Errors: not_found; io (not a regular file, unreadable); limit_exceeded above
/// `max_bytes`.
Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, std::uint64_t max_bytes);

/// Writes a file in one step: whoever opens `path` sees the old content or the new one. Errors: io.
Status write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);

/// Fails with io where `path` cannot become a file: its folder is missing or it names a folder.
Status check_writable(const std::filesystem::path& path);

}  // namespace photond
