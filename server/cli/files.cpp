#include "server/cli/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <mutex>
#include <string>

#include "server/store/file.h"

namespace photond {
namespace {

Error io_error(const std::string& what) { return {ErrorCode::io, what + ": " + std::strerror(errno), {}}; }

std::mutex unfinished_mutex;
std::filesystem::path unfinished;  ///< the part that is being written, or empty

/// A file that gets its name when it is whole. Until then it stands beside it under a name of its own; what is not
/// finished goes with the object, or by drop_unfinished_file.
class Part {
 public:
  explicit Part(const std::filesystem::path& path) : path_(path), part_(path) {
    part_ += ".part" + std::to_string(getpid());
    const std::lock_guard lock(unfinished_mutex);
    file_ = File(::open(part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
    if (file_.is_open()) unfinished = part_;
  }
  ~Part() {
    const std::lock_guard lock(unfinished_mutex);
    if (!unfinished.empty()) ::unlink(unfinished.c_str());
    unfinished.clear();
  }
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  /// Else errno tells why.
  bool is_open() const { return file_.is_open(); }
  Status write(std::span<const std::byte> bytes) { return file_.write(bytes); }
  Status finish() {
    if (const Status closed = file_.close(); !closed) return closed;
    const std::lock_guard lock(unfinished_mutex);
    if (::rename(part_.c_str(), path_.c_str()) != 0) return io_error("cannot be written");
    unfinished.clear();
    return Done{};
  }

 private:
  const std::filesystem::path path_;
  std::filesystem::path part_;
  File file_;
};

/// The file that a path leads to; it need not exist.
std::filesystem::path behind_links(std::filesystem::path path) {
  std::error_code failure;
  for (int links = 0; links < 40 && std::filesystem::is_symlink(path, failure); ++links) {
    path = path.parent_path() / std::filesystem::read_symlink(path, failure);
  }
  return path;
}

/// The standard stream that is the very file of this name, as /dev/stdout may be; -1: none. Opened by its name it would
/// be written from its beginning, whatever stands there.
int standard_stream(const std::filesystem::path& path) {
  struct stat named {}, own {};
  if (::stat(path.c_str(), &named) != 0 || !(S_ISREG(named.st_mode) || S_ISSOCK(named.st_mode))) return -1;
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
    if (::fstat(stream, &own) == 0 && own.st_dev == named.st_dev && own.st_ino == named.st_ino) return stream;
  }
  return -1;
}

/// Whether it is written into and stays what it is.
bool is_device_or_pipe(const std::filesystem::path& path) {
  std::error_code failure;
  const auto status = std::filesystem::status(path, failure);
  return std::filesystem::is_character_file(status) || std::filesystem::is_block_file(status) ||
         std::filesystem::is_fifo(status);
}

Status check_writable(const std::filesystem::path& path) {
  if (path.empty()) return Error{ErrorCode::io, "cannot be written: its name is empty", {}};
  if (standard_stream(path) >= 0) return Done{};
  if (is_device_or_pipe(path)) return ::access(path.c_str(), W_OK) == 0 ? Status(Done{}) : io_error("cannot be written");
  std::error_code failure;
  const auto status = std::filesystem::status(path, failure);
  if (std::filesystem::is_directory(status)) return Error{ErrorCode::io, "cannot be written: it is a folder", {}};
  if (std::filesystem::is_socket(status)) return Error{ErrorCode::io, "cannot be written: it is a socket", {}};
  if (failure && status.type() != std::filesystem::file_type::not_found) {
    return Error{ErrorCode::io, "cannot be written: " + failure.message(), {}};
  }
  const auto file = behind_links(path);
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  if (!std::filesystem::is_directory(folder, failure)) {
    return Error{ErrorCode::io, "cannot be written: its folder does not exist", {}};
  }
  // Permissions alone do not tell: nobody may write to /proc or to a read-only disk.
  return Part(file).is_open() ? Status(Done{}) : io_error("cannot be written");
}

Status put_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  if (const int stream = standard_stream(path); stream >= 0) return File(::dup(stream)).write(bytes);
  if (is_device_or_pipe(path)) {
    File file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
    return file.is_open() ? file.write(bytes) : io_error("cannot be written");
  }
  Part part(behind_links(path));
  if (!part.is_open()) return io_error("cannot be written");
  if (const Status written = part.write(bytes); !written) return written;
  return part.finish();
}

/// Whether both names lead to one file, which need not exist yet.
bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code failure;
  const auto whole = [&failure](const std::string& path) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(behind_links(path), failure), failure);
  };
  const std::filesystem::path first = whole(a);
  return !first.empty() && first == whole(b);  // empty: it leads nowhere
}

}  // namespace

Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, std::uint64_t max_bytes) {
  std::error_code failure;
  const auto status = std::filesystem::status(path, failure);
  if (status.type() == std::filesystem::file_type::not_found) {
    return Error{ErrorCode::not_found, "there is no such file", {}};
  }
  if (failure) return Error{ErrorCode::io, "cannot be read: " + failure.message(), {}};
  // Anything else (a folder, a pipe, a device) could block or never end.
  if (!std::filesystem::is_regular_file(status)) return Error{ErrorCode::io, "is not a regular file", {}};
  const std::uint64_t size = std::filesystem::file_size(path, failure);
  if (failure) return Error{ErrorCode::io, "cannot be read: " + failure.message(), {}};
  if (size > max_bytes) {
    return Error{ErrorCode::limit_exceeded, "is larger than " + std::to_string(max_bytes >> 20) + " MiB", {}};
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) return io_error("cannot be read");
  std::vector<std::byte> bytes(size);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (static_cast<std::uint64_t>(file.gcount()) != size) return io_error("cannot be read to its end");
  return bytes;
}

Status write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  const Status put = put_file(path, bytes);
  return put ? put : Error{ErrorCode::io, put.error().message, {}};  // who tells it names the file
}

void drop_unfinished_file() {
  unfinished_mutex.lock();  // for good: nothing is begun any more
  if (!unfinished.empty()) ::unlink(unfinished.c_str());
}

Status check_outputs(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const auto is_this = [&](const std::string& other) { return is_same_file(outputs[i], other); };
    if (std::any_of(outputs.begin(), outputs.begin() + static_cast<std::ptrdiff_t>(i), is_this))
      return invalid_input("would be written twice", outputs[i]);
    if (std::any_of(inputs.begin(), inputs.end(), is_this)) return invalid_input("is read and would be overwritten", outputs[i]);
    if (const auto writable = check_writable(outputs[i]); !writable)
      return Error{writable.error().code, writable.error().message, outputs[i]};
  }
  return Done{};
}

}  // namespace photond
