#include "server/store/map_files.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>

#include "server/store/file.h"
#include "server/store/map_key_text.h"

namespace photond {

namespace {

namespace fs = std::filesystem;
using WallTime = std::chrono::system_clock::time_point;

constexpr const char* kTemporary = ".new";
constexpr const char* kPlain = ".map";
constexpr const char* kPinned = ".pinned";

WallTime time_of(const timespec& t) {
  return WallTime(std::chrono::duration_cast<WallTime::duration>(std::chrono::seconds(t.tv_sec) +
                                                                 std::chrono::nanoseconds(t.tv_nsec)));
}

/// What a file in the folder is; nothing where it is none of this photon stage.
std::optional<MapFiles::Info> read_info(const fs::path& path) {
  const std::string extension = path.extension().string();
  const auto key = parse_key(path.stem().string());
  if (!key || (extension != kPlain && extension != kPinned)) return std::nullopt;
  const Result<File> file = File::open(path, O_RDONLY);
  struct stat status {};
  std::array<std::byte, kFactsBytes> first;
  if (!file || ::fstat(file->descriptor(), &status) != 0 ||
      ::pread(file->descriptor(), first.data(), first.size(), 0) != static_cast<ssize_t>(first.size())) {
    return std::nullopt;
  }
  const auto facts = read_facts(first, *key);
  if (!facts) return std::nullopt;
  return MapFiles::Info{*key, static_cast<std::uint64_t>(status.st_size), *facts, time_of(status.st_mtim),
                        extension == kPinned};
}

std::optional<SharedSpan> map_file(const File& file) {
  struct stat status {};
  if (::fstat(file.descriptor(), &status) != 0 || status.st_size <= 0) return std::nullopt;
  const auto size = static_cast<std::size_t>(status.st_size);
  // All of it is read at once: it is checked before it is used.
  void* memory = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE | MAP_POPULATE, file.descriptor(), 0);
  if (memory == MAP_FAILED) return std::nullopt;
  std::shared_ptr<const void> owner(memory, [size](const void* p) { ::munmap(const_cast<void*>(p), size); });
  return SharedSpan{{static_cast<const std::byte*>(memory), size}, std::move(owner)};
}

Status write_file(const fs::path& path, std::span<const std::span<const std::byte>> pieces) {
  Result<File> file = File::open(path, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file) return file.error();
  for (const auto& piece : pieces) {
    if (const Status written = file->write(piece); !written) return written;
  }
  return file->sync();
}

}  // namespace

Result<std::unique_ptr<MapFiles>> MapFiles::open(const fs::path& folder, std::uint64_t budget_bytes) {
  if (const Status made = make_folder(folder); !made) return made.error();
  std::unique_ptr<MapFiles> files(new MapFiles(folder, budget_bytes));
  if (const Status scanned = files->scan(); !scanned) return scanned.error();
  return files;
}

Status MapFiles::scan() {
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder_, failure)) {
    auto info = read_info(entry.path());
    // What else lies here is of no use: unfinished, or of another photon stage.
    if (!info || !entries_.emplace(info->key, *info).second) {
      ::unlink(entry.path().c_str());
      continue;
    }
    bytes_ += info->bytes;
  }
  if (failure) return system_error("cannot read the folder " + folder_.string(), failure.value());
  make_room(0);
  return Done{};
}

fs::path MapFiles::path_of(const Info& info) const {
  return folder_ / (key_text(info.key) + (info.pinned ? kPinned : kPlain));
}

std::optional<SharedSpan> MapFiles::map(const MapKey& key) {
  std::unique_lock lock(mutex_);
  const auto found = entries_.find(key);
  if (found == entries_.end()) return std::nullopt;
  const Result<File> file = File::open(path_of(found->second), O_RDONLY);
  if (!file) {
    remove(found);
    return std::nullopt;
  }
  found->second.last_use = std::chrono::system_clock::now();
  ++found->second.hits;
  // Only the order of eviction after a restart depends on it.
  (void)::futimens(file->descriptor(), nullptr);
  lock.unlock();
  return map_file(*file);
}

Status MapFiles::put(const MapKey& key, const MapFacts& facts, std::span<const std::span<const std::byte>> pieces) {
  Info info{key, 0, facts, std::chrono::system_clock::now(), false};
  for (const auto& piece : pieces) info.bytes += piece.size();
  {
    const std::lock_guard lock(mutex_);
    if (entries_.contains(key)) return Done{};
    make_room(info.bytes);
    if (bytes_ + info.bytes > budget_bytes_) return Done{};
  }
  const fs::path temporary = folder_ / (std::to_string(next_temporary_++) + kTemporary);
  if (const Status written = write_file(temporary, pieces); !written) {
    ::unlink(temporary.c_str());
    return written;
  }
  const std::lock_guard lock(mutex_);
  if (::rename(temporary.c_str(), path_of(info).c_str()) != 0) {
    const Error failure = system_error("cannot rename " + temporary.string(), errno);
    ::unlink(temporary.c_str());
    return failure;
  }
  if (entries_.emplace(key, info).second) bytes_ += info.bytes;
  make_room(0);
  return sync_folder(folder_);
}

bool MapFiles::erase(const MapKey& key) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  if (found == entries_.end()) return false;
  remove(found);
  return true;
}

bool MapFiles::pin(const MapKey& key, bool pinned) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  if (found == entries_.end()) return false;
  Info changed = found->second;
  changed.pinned = pinned;
  if (::rename(path_of(found->second).c_str(), path_of(changed).c_str()) != 0) return false;
  found->second = changed;
  return sync_folder(folder_).ok();
}

std::uint64_t MapFiles::evict(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  const std::uint64_t before = bytes_;
  while (before - bytes_ < bytes && evict_oldest()) {}
  return before - bytes_;
}

std::uint64_t MapFiles::evictable_bytes() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t bytes = 0;
  for (const auto& [key, info] : entries_) bytes += info.pinned ? 0 : info.bytes;
  return bytes;
}

void MapFiles::make_room(std::uint64_t bytes) {
  while (bytes_ + bytes > budget_bytes_ && evict_oldest()) {}
}

bool MapFiles::evict_oldest() {
  auto oldest = entries_.end();
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    if (entry->second.pinned) continue;
    if (oldest == entries_.end() || entry->second.last_use < oldest->second.last_use) oldest = entry;
  }
  if (oldest == entries_.end()) return false;
  ++evictions_;
  remove(oldest);
  return true;
}

// Whoever has mapped the file keeps what is mapped.
void MapFiles::remove(Entries::iterator entry) {
  ::unlink(path_of(entry->second).c_str());
  bytes_ -= entry->second.bytes;
  entries_.erase(entry);
}

std::optional<MapFiles::Info> MapFiles::find(const MapKey& key) const {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  return found == entries_.end() ? std::nullopt : std::optional(found->second);
}

std::vector<MapFiles::Info> MapFiles::list() const {
  const std::lock_guard lock(mutex_);
  std::vector<Info> infos;
  for (const auto& [key, info] : entries_) infos.push_back(info);
  return infos;
}

MapFiles::Totals MapFiles::totals() const {
  const std::lock_guard lock(mutex_);
  return {bytes_, entries_.size(), evictions_};
}

}  // namespace photond
