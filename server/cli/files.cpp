#include "server/cli/files.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>

namespace photond {
namespace {

Error io_error(const std::string& what) { return {ErrorCode::io, what + ": " + std::strerror(errno), {}}; }

/// Where a file is written before it has its name.
std::filesystem::path part_of(const std::filesystem::path& path) {
  auto part = path;
  part += ".part" + std::to_string(getpid());
  return part;
}

Status check_writable(const std::filesystem::path& path) {
  std::error_code failure;
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (!std::filesystem::is_directory(folder, failure)) {
    return Error{ErrorCode::io, "cannot be written: its folder does not exist", {}};
  }
  if (std::filesystem::is_directory(path, failure)) {
    return Error{ErrorCode::io, "cannot be written: it is a folder", {}};
  }
  // Permissions alone do not tell: nobody may write to /proc or to a read-only disk.
  const auto part = part_of(path);
  if (!std::ofstream(part, std::ios::binary)) return io_error("cannot be written");
  std::filesystem::remove(part, failure);
  return Done{};
}

/// Whether both names lead to one file, which need not exist yet.
bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code failure;
  const auto whole = [&failure](const std::string& path) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(path, failure), failure);
  };
  return whole(a) == whole(b);
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
  const auto part = part_of(path);
  std::ofstream file(part, std::ios::binary | std::ios::trunc);
  if (!file) return io_error("cannot be written");
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  std::error_code failure;
  if (!file) {
    const Error error = io_error("cannot be written");
    std::filesystem::remove(part, failure);
    return error;
  }
  std::filesystem::rename(part, path, failure);
  if (!failure) return Done{};
  const Error error{ErrorCode::io, "cannot be written: " + failure.message(), {}};
  std::filesystem::remove(part, failure);
  return error;
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
