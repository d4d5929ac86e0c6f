#include "server/store/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace photond {

Error disk_full(const std::string& message) { return {ErrorCode::limit_exceeded, message, "disk"}; }

bool is_disk_full(const Error& error) {
  return error.code == ErrorCode::limit_exceeded && error.where == "disk";
}

Error disk_unreachable(const std::string& message) { return {ErrorCode::io, message, "disk"}; }

bool is_disk_unreachable(const Error& error) { return error.code == ErrorCode::io && error.where == "disk"; }

Error system_error(const std::string& what, int number) {
  const std::string message = what + ": " + std::strerror(number);
  if (number == ENOSPC || number == EDQUOT) return disk_full(message);
  if (number == EMFILE || number == ENFILE) return disk_unreachable(message);
  return {ErrorCode::io, message, ""};
}

File::~File() {
  if (is_open()) ::close(descriptor_);
}

File& File::operator=(File&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

Result<File> File::open(const std::filesystem::path& path, int flags, unsigned mode) {
  int descriptor = -1;
  do descriptor = ::open(path.c_str(), flags | O_CLOEXEC, mode);
  while (descriptor < 0 && errno == EINTR);
  if (descriptor < 0) return system_error("cannot open " + path.string(), errno);
  return File(descriptor);
}

Status File::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return system_error("cannot write", errno);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return Done{};
}

Status File::read_at(std::span<std::byte> bytes, std::uint64_t offset) const {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return system_error("cannot read", errno);
    if (got == 0) return Error{ErrorCode::io, "the file ends early", ""};
    bytes = bytes.subspan(static_cast<std::size_t>(got));
    offset += static_cast<std::uint64_t>(got);
  }
  return Done{};
}

Status File::close() {
  if (::close(std::exchange(descriptor_, -1)) != 0) return system_error("cannot write", errno);
  return Done{};
}

Status File::sync() {
  if (::fsync(descriptor_) != 0) return system_error("cannot write to the disk", errno);
  return Done{};
}

Status sync_folder(const std::filesystem::path& folder) {
  Result<File> opened = File::open(folder, O_RDONLY | O_DIRECTORY);
  return opened ? opened->sync() : opened.error();
}

Status make_folder(const std::filesystem::path& folder) {
  std::error_code failure;
  if (std::filesystem::is_directory(folder, failure)) return Done{};
  if (const std::filesystem::path parent = folder.parent_path(); !parent.empty() && parent != folder) {
    if (const Status made = make_folder(parent); !made) return made;
  }
  if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) {
    return system_error("cannot create the folder " + folder.string(), errno);
  }
  if (!std::filesystem::is_directory(folder, failure)) {
    return Error{ErrorCode::io, folder.string() + " is not a folder", ""};
  }
  return Done{};
}

Result<std::vector<std::byte>> read_whole(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0 && errno == ENOENT) return Error{ErrorCode::not_found, path.string() + " is missing", ""};
  if (descriptor < 0) return system_error("cannot open " + path.string(), errno);
  const File file(descriptor);
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) return system_error("cannot read " + path.string(), errno);
  std::vector<std::byte> bytes(static_cast<std::size_t>(status.st_size));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got = ::read(descriptor, bytes.data() + done, bytes.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return system_error("cannot read " + path.string(), errno);
    if (got == 0) return Error{ErrorCode::io, path.string() + " became shorter while it was read", ""};
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

}  // namespace photond
