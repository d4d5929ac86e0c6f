#include "server/store/data_directory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <utility>

#include "core/base/digest.h"

namespace photond {

namespace {

constexpr const char* kDatabase = "photond.db";

std::string owner_of(const std::filesystem::path& lock) {
  const Result<std::vector<std::byte>> text = read_whole(lock);
  if (!text || text->empty()) return "another photond";
  const std::string pid(reinterpret_cast<const char*>(text->data()), text->size());
  return "another photond (process " + pid.substr(0, pid.find('\n')) + ")";
}

Status write_owner(File& lock) {
  if (::ftruncate(lock.descriptor(), 0) != 0) return system_error("cannot write the lock file", errno);
  const std::string pid = std::to_string(::getpid()) + "\n";
  return lock.write(std::as_bytes(std::span(pid.data(), pid.size())));
}

bool holds_blobs(const std::filesystem::path& folder) {
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
    if (digest_from_hex(entry.path().filename().string())) return true;
  }
  return false;
}

/// A new database beside files of an old one knows none of them, and what no row names is litter.
Status check_database(const std::filesystem::path& folder) {
  std::error_code missing;
  const std::uintmax_t size = std::filesystem::file_size(folder / kDatabase, missing);
  if (!missing && size > 0) return Done{};
  for (const char* name : {"scenes", "environments", "frames", "checkpoints"}) {
    if (!holds_blobs(folder / name)) continue;
    return Error{ErrorCode::io,
                 "the database " + (folder / kDatabase).string() + " is missing or empty, though there are files in " +
                     name + "/. Restore it from a backup, or move scenes, environments, frames and checkpoints aside to "
                     "start without them; nothing was changed",
                 ""};
  }
  return Done{};
}

}  // namespace

std::string default_data_directory() {
  // By the XDG Base Directory Specification a relative path is to be ignored.
  if (const char* data = std::getenv("XDG_DATA_HOME"); data != nullptr && data[0] == '/') {
    return std::string(data) + "/photond";
  }
  if (const char* home = std::getenv("HOME"); home != nullptr && home[0] == '/') {
    return std::string(home) + "/.local/share/photond";
  }
  return {};
}

std::string DataDirectory::database() const { return (path_ / kDatabase).string(); }

Result<DataDirectory> DataDirectory::open(const std::string& path) {
  if (path.empty()) return Error{ErrorCode::invalid_input, "no data directory is given (--data DIR)", ""};
  const std::filesystem::path folder = std::filesystem::absolute(path);
  if (const Status made = make_folder(folder); !made) return made.error();
  Result<File> lock = File::open(folder / "lock", O_RDWR | O_CREAT);
  if (!lock) return lock.error();
  if (::flock(lock->descriptor(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return system_error("cannot lock " + folder.string(), errno);
    return Error{ErrorCode::conflict,
                 "the data directory " + folder.string() + " is used by " + owner_of(folder / "lock") +
                     "; choose another one with --data",
                 ""};
  }
  // On a full disk the number may be missing: the lock itself needs no space.
  if (const Status written = write_owner(*lock); !written && !is_disk_full(written.error())) {
    return written.error();
  }
  if (const Status whole = check_database(folder); !whole) return whole.error();
  return DataDirectory(folder, std::move(*lock));
}

}  // namespace photond
