#include "server/store/blobs.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <utility>

namespace photond {

namespace {

namespace fs = std::filesystem;

constexpr const char* kTemporary = ".new";  // ends the name of a file that is being written

/// The file's size, or 0 where there is none.
std::uint64_t size_of(const fs::path& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
}

Result<Digest> digest_of(const FileBytes& bytes) {
  std::vector<std::byte> piece(std::min<std::uint64_t>(bytes.length, 1 << 20));
  Hasher hasher;
  for (std::uint64_t at = 0; at < bytes.length; at += piece.size()) {
    piece.resize(std::min<std::uint64_t>(piece.size(), bytes.length - at));
    if (const Status read = bytes.file->read_at(piece, bytes.first + at); !read) return read.error();
    hasher.update(piece);
  }
  return hasher.finish();
}

}  // namespace

Result<std::unique_ptr<Blobs>> Blobs::open(const fs::path& folder) {
  if (const Status made = make_folder(folder); !made) return made.error();
  std::unique_ptr<Blobs> blobs(new Blobs(folder));
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder, failure)) {
    if (entry.path().extension() == kTemporary) ::unlink(entry.path().c_str());
  }
  if (failure) return system_error("cannot read the folder " + folder.string(), failure.value());
  const Status counted = blobs->list([&](const Digest& name) -> Status {
    blobs->total_bytes_ += size_of(blobs->path_of(name));
    return Done{};
  });
  if (!counted) return counted.error();
  return blobs;
}

// One level of folders by the first byte would only help beyond some ten thousand files.
fs::path Blobs::path_of(const Digest& name) const { return folder_ / to_hex(name); }

Status Blobs::list(const std::function<Status(const Digest&)>& visit) const {
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder_, failure)) {
    const auto name = digest_from_hex(entry.path().filename().string());
    if (!name) continue;
    if (const Status visited = visit(*name); !visited) return visited;
  }
  if (failure) return system_error("cannot read the folder " + folder_.string(), failure.value());
  return Done{};
}

Status Blobs::look() const {
  std::error_code failure;
  if (fs::is_directory(folder_, failure)) return Done{};
  return disk_unreachable("the folder " + folder_.filename().string() + " of the data directory is not there");
}

Error Blobs::explained(Error error) const {
  const Status there = look();
  return there ? std::move(error) : there.error();
}

Blobs::Written::~Written() {
  if (!temporary_.empty()) ::unlink(temporary_.c_str());  // fails, as it should, once the file is renamed
}

Result<Blobs::Written> Blobs::write(const Content& content) {
  Written written(folder_ / (std::to_string(next_temporary_++) + kTemporary));
  Result<File> file = File::open(written.temporary_, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file) return explained(file.error());
  Hasher hasher;
  const Status given = content([&](std::span<const std::byte> piece) {
    hasher.update(piece);
    return file->write(piece);
  });
  if (!given) return given.error();
  if (const Status synced = file->sync(); !synced) return synced.error();
  written.name_ = hasher.finish();
  return written;
}

Status Blobs::publish(const Written& written) {
  const fs::path path = path_of(written.name_);
  const std::lock_guard lock(changing_);
  const std::uint64_t before = size_of(path);  // replaced where it is there already: it may be a damaged one
  if (::rename(written.temporary_.c_str(), path.c_str()) != 0) {
    return explained(system_error("cannot rename " + written.temporary_.string(), errno));
  }
  total_bytes_ += size_of(path) - before;
  checked_.insert(written.name_);
  return sync_folder(folder_);
}

Result<Digest> Blobs::put(const Content& content) {
  const Result<Written> written = write(content);
  if (!written) return written.error();
  if (const Status published = publish(*written); !published) return published.error();
  return written->name();
}

Result<Digest> Blobs::put(std::span<const std::byte> bytes) {
  return put([bytes](const Sink& sink) { return sink(bytes); });
}

Result<Blobs::Bytes> Blobs::get(const Digest& name) {
  Result<std::vector<std::byte>> bytes = read_whole(path_of(name));
  if (!bytes) return explained(bytes.error());
  if (sha256(*bytes) == name) return std::make_shared<const std::vector<std::byte>>(std::move(*bytes));
  return drop_damaged(name);
}

Result<FileBytes> Blobs::open_file(const Digest& name) {
  const fs::path path = path_of(name);
  const std::uint64_t size = size_of(path);
  Result<File> opened = File::open(path, O_RDONLY);
  if (!opened) {
    if (!fs::exists(path)) return explained({ErrorCode::not_found, path.string() + " is missing", ""});
    return opened.error();
  }
  FileBytes bytes{std::make_shared<const File>(std::move(*opened)), 0, size};
  {
    const std::lock_guard lock(changing_);
    if (checked_.contains(name)) return bytes;
  }
  const Result<Digest> found = digest_of(bytes);
  if (!found) return found.error();
  if (*found != name) return drop_damaged(name);
  const std::lock_guard lock(changing_);
  checked_.insert(name);
  return bytes;
}

Error Blobs::drop_damaged(const Digest& name) {
  if (const Status removed = remove(name); !removed) return removed.error();
  return {ErrorCode::not_found, "the file " + path_of(name).string() + " was damaged and is dropped", ""};
}

Status Blobs::remove(const Digest& name) {
  const fs::path path = path_of(name);
  const std::lock_guard lock(changing_);
  const std::uint64_t size = size_of(path);
  if (::unlink(path.c_str()) != 0) {
    if (errno == ENOENT) return look();
    return system_error("cannot remove " + path.string(), errno);
  }
  total_bytes_ -= size;
  checked_.erase(name);
  return Done{};
}

Result<std::size_t> Blobs::sweep(const std::function<bool(const Digest&)>& wanted) {
  std::vector<Digest> unwanted;
  const Status listed = list([&](const Digest& name) -> Status {
    if (!wanted(name)) unwanted.push_back(name);
    return Done{};
  });
  if (!listed) return listed.error();
  for (const Digest& name : unwanted) {
    if (const Status removed = remove(name); !removed) return removed.error();
  }
  return unwanted.size();
}

}  // namespace photond
