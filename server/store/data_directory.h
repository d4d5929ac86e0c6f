#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "server/store/file.h"

namespace photond {

/// `$XDG_DATA_HOME/photond`, or `~/.local/share/photond`; empty where neither variable is set.
std::string default_data_directory();

/// The one folder in which a photond keeps its state, locked while the object lives:
///   lock, photond.db (with -wal and -shm), scenes/, environments/, frames/, checkpoints/, maps/.
/// Backing it up means copying it while no photond runs.
class DataDirectory {
 public:
  /// Creates the folder, readable by its owner only, where it is missing, and locks it. Errors: conflict where
  /// another photond uses it, with its process id; io, also where its files are there without the database.
  static Result<DataDirectory> open(const std::string& path);

  const std::filesystem::path& path() const { return path_; }
  std::string database() const;
  /// A folder in it.
  std::filesystem::path folder(const char* name) const { return path_ / name; }

 private:
  DataDirectory(std::filesystem::path path, File lock) : path_(std::move(path)), lock_(std::move(lock)) {}

  std::filesystem::path path_;
  File lock_;  ///< flock(2): the kernel gives it back, however the process ends
};

}  // namespace photond
