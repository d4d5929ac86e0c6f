#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace photond {

/// The failure of a system call, by errno. No space left (or no quota) is disk_full, no descriptor left is
/// disk_unreachable, everything else io.
Error system_error(const std::string& what, int number);
/// limit_exceeded with `where` "disk": answered by 507, and a reason for jobs to pause.
Error disk_full(const std::string& message);
bool is_disk_full(const Error& error);
/// io with `where` "disk": answered by 503, and a reason for jobs to pause.
Error disk_unreachable(const std::string& message);
bool is_disk_unreachable(const Error& error);

/// An open file, closed with the object.
class File {
 public:
  File() = default;
  explicit File(int descriptor) : descriptor_(descriptor) {}
  ~File();
  File(File&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  File& operator=(File&& other) noexcept;

  /// `flags` and `mode` as open(2). Errors: system_error.
  static Result<File> open(const std::filesystem::path& path, int flags, unsigned mode = 0600);

  int descriptor() const { return descriptor_; }
  bool is_open() const { return descriptor_ >= 0; }
  /// Writes everything.
  Status write(std::span<const std::byte> bytes);
  /// Returns once what was written is on the disk.
  Status sync();
  /// Errors: what the disk, or the machine that has it, could not take of what was written.
  Status close();
  /// Fills `bytes` with what stands from `offset` on; several threads may at once. Errors: io, also where it ends.
  Status read_at(std::span<std::byte> bytes, std::uint64_t offset) const;

 private:
  int descriptor_ = -1;
};

/// A part of a file, or all of it, which can be read though its name may go meanwhile.
struct FileBytes {
  std::shared_ptr<const File> file;
  std::uint64_t first = 0;
  std::uint64_t length = 0;
};

/// Makes what was renamed, created or removed in a folder durable.
Status sync_folder(const std::filesystem::path& folder);
/// Creates a folder that only its owner may enter, with its parents; one that exists is left as it is.
Status make_folder(const std::filesystem::path& folder);
/// The whole file. Errors: not_found, io.
Result<std::vector<std::byte>> read_whole(const std::filesystem::path& path);

}  // namespace photond
