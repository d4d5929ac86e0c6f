#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/base/digest.h"
#include "core/base/result.h"

namespace photond {

/// What a key may do; each includes what stands before it.
enum class Scope : std::uint8_t {
  read,    ///< look at everything
  submit,  ///< upload scenes and environments, submit jobs, change and delete one's own of these
  admin    ///< change and delete everything
};
const char* scope_name(Scope scope);  ///< "read", "submit", "admin"
std::optional<Scope> scope_from_name(const std::string& name);

/// What one key may take at once; nothing: what the service allows altogether.
struct KeyLimits {
  std::optional<std::uint64_t> jobs;     ///< its own, not yet ended
  std::optional<std::uint64_t> bytes;    ///< of uploaded scenes and environments
  std::optional<std::uint64_t> streams;  ///< event streams and long polls
};

/// By whom something is done, as far as it counts; nobody: no key was needed.
struct Owner {
  std::string key;  ///< its id, or empty
  KeyLimits limits;
  bool admin = false;

  /// Whether what `owner` (id of a key) has made is theirs to change.
  bool may_change(const std::string& owner) const { return admin || key == owner; }
};

/// A key as it is kept: its secret is not.
struct KeyRecord {
  std::string id;  ///< "k-" and eight hexadecimal digits
  Digest hash;     ///< SHA-256 of the secret
  Scope scope = Scope::read;
  KeyLimits limits;
  std::chrono::system_clock::time_point created{};
  std::string label;
};

struct NewKey {
  KeyRecord record;
  std::string secret;  ///< "photond_" and 64 hexadecimal digits; shown once
};
/// A key of 256 random bits. Errors: io.
Result<NewKey> make_key(Scope scope, const KeyLimits& limits, const std::string& label);

/// The text file `keys` of a data directory: a line per key. It is not part of the database, so that keys can be made
/// and revoked while a service runs, which holds the only connection to that.
class KeyFile {
 public:
  explicit KeyFile(const std::filesystem::path& data) : path_(data / "keys") {}

  const std::filesystem::path& path() const { return path_; }
  bool exists() const { return std::filesystem::exists(path_); }
  /// None where there is no file. Errors: io, also where the file is not one of keys.
  Result<std::vector<KeyRecord>> read() const;
  /// Each change replaces the file whole; several programs may do it at once. A key is added once its secret is where
  /// it is kept: where `hand_over` fails, nothing is changed.
  Status add(const KeyRecord& key, const std::function<Status()>& hand_over = [] { return Done{}; }) const;
  /// Errors: not_found.
  Status revoke(const std::string& id) const;

 private:
  template <class Change>
  Status change(const Change& change) const;
  Status write(const std::vector<KeyRecord>& keys) const;

  std::filesystem::path path_;
};

/// The keys that a running service honours: those of the file, as it is now. Thread-safe.
class Keyring {
 public:
  /// Empty path: no keys, everything is open.
  explicit Keyring(const std::optional<KeyFile>& file) : file_(file) {}

  /// Whether requests need a key. Once they do it stays so: a file that goes opens nothing.
  bool required() const;
  /// The key of this secret, found in the same time wherever it stands. Errors: io where the file cannot be read.
  Result<std::optional<KeyRecord>> find(const std::string& secret) const;

 private:
  Status refresh() const;

  const std::optional<KeyFile> file_;
  mutable std::mutex mutex_;
  mutable bool required_ = false;
  mutable std::vector<KeyRecord> keys_;
  using Version = std::array<std::uint64_t, 4>;  ///< inode, time of the last change in two parts, size
  mutable Version version_{};                    ///< of what `keys_` was read from
};

}  // namespace photond
