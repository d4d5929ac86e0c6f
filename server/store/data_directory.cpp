#include "server/store/data_directory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <utility>

namespace photond {

namespace {

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
  return DataDirectory(folder, std::move(*lock));
}

}  // namespace photond
