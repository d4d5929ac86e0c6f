#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/digest.h"
#include "core/base/result.h"
#include "server/store/file.h"

namespace photond {

/// Files of one folder named by the SHA-256 of their content. Once `put` has returned a blob is on the disk, whole;
/// what reads back differently is never served. Whoever keeps blobs has a folder of its own and refers to them by
/// rows of the database that are written afterwards; a crash in between leaves blobs without a row, for `sweep`.
/// While the folder is not there nothing is said of what it holds: that is disk_unreachable. Thread-safe.
class Blobs {
 public:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;

  /// Creates the folder where it is missing and removes what an interrupted `put` left. Errors: system_error.
  static Result<std::unique_ptr<Blobs>> open(const std::filesystem::path& folder);

  /// Takes the pieces of a content in order.
  using Sink = std::function<Status(std::span<const std::byte>)>;
  using Content = std::function<Status(const Sink&)>;
  class Written;
  /// Writes what `content` gives to its sink to the disk, whole, which takes as long as it is large; it is no blob yet.
  /// Errors: the content's; system_error, so limit_exceeded at "disk" where there is no space.
  Result<Written> write(const Content& content);
  /// Makes a blob of it: rename, fsync of the folder. Errors: system_error.
  Status publish(const Written& written);
  /// Both.
  Result<Digest> put(const Content& content);
  Result<Digest> put(std::span<const std::byte> bytes);

  /// Errors: not_found (also for a damaged one, which is removed), io.
  Result<Bytes> get(const Digest& name);
  /// The same as a file, for what is large: nothing of it is kept in memory. Checked whole when it is first opened, but
  /// where this process has written it.
  Result<FileBytes> open_file(const Digest& name);
  /// Removing what is not there is no error.
  Status remove(const Digest& name);
  /// Removes every blob for which `wanted` is false; returns how many. For the start: what is just being put has no
  /// row yet.
  Result<std::size_t> sweep(const std::function<bool(const Digest&)>& wanted);

  /// Whether the folder is there. Errors: disk_unreachable.
  Status look() const;
  /// The size of all blobs together.
  std::uint64_t total_bytes() const { return total_bytes_; }

  std::filesystem::path path_of(const Digest& name) const;

 private:
  explicit Blobs(std::filesystem::path folder) : folder_(std::move(folder)) {}

  Status list(const std::function<Status(const Digest&)>& visit) const;
  Error drop_damaged(const Digest& name);
  /// What a failure comes from, where that is the folder.
  Error explained(Error error) const;

  const std::filesystem::path folder_;
  std::mutex changing_;  ///< names in the folder, the total and the next change together
  std::set<Digest> checked_;  ///< known to be what their names say
  std::atomic<std::uint64_t> total_bytes_{0};
  std::atomic<std::uint64_t> next_temporary_{0};
};

/// A content on the disk that has no name there yet, and goes with the object unless it got one.
class Blobs::Written {
 public:
  Written(std::filesystem::path temporary) : temporary_(std::move(temporary)) {}
  ~Written();
  Written(Written&& other) noexcept : temporary_(std::exchange(other.temporary_, {})), name_(other.name_) {}
  Written& operator=(Written&&) = delete;

  const Digest& name() const { return name_; }

 private:
  friend class Blobs;
  std::filesystem::path temporary_;
  Digest name_;
};

}  // namespace photond
