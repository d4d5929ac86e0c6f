#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace photond {

/// The bytes of a regular file. Errors: not_found; io (not a regular file, unreadable); limit_exceeded above
/// `max_bytes`.
Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, std::uint64_t max_bytes);

/// Writes the file that `path` leads to, links followed. It is replaced in one step: whoever opens it sees the old content
/// or the new one. A device, a pipe or what standard output or error go to is written into; a pipe waits for its reader.
/// Errors: io.
Status write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);

/// For a process that ends at once: removes what write_file has begun. It begins nothing, and finishes nothing, after
/// that.
void drop_unfinished_file();

/// Fails where not all of `outputs` can become files, with the first of those in `where`: io where its folder is missing
/// or takes no files, or it names a folder or a socket; invalid_input where it is named twice, or is one of `inputs`.
Status check_outputs(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs);

}  // namespace photond
