#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/store/blobs.h"
#include "server/store/database.h"
#include "server/store/records.h"

namespace photond {

/// One uploaded environment map; its id is the SHA-256 of the file.
struct EnvironmentRecord {
  Digest id;
  std::string media_type;  ///< image/x-exr or image/vnd.radiance
  std::uint64_t bytes = 0;
  int width = 0;
  int height = 0;
  std::vector<std::string> warnings;
  WallTime created{};
  std::string owner{};  ///< id of the API key that uploaded it first; empty: none was needed
  std::string name{};   ///< what people call it; may be empty
};

/// The environment maps that the service keeps: files, and rows of the database that say which there are.
/// Thread-safe.
class Environments {
 public:
  /// `database` must have the tables of schema() and outlive the object. Errors: io.
  static Result<std::unique_ptr<Environments>> open(Database& database, const std::filesystem::path& folder);

  /// One of the same id is left as it is. Errors: limit_exceeded at "disk", also where its owner's uploads would exceed
  /// `owner_bytes`; io.
  Status put(const EnvironmentRecord& record, const std::vector<std::byte>& bytes,
             const std::optional<std::uint64_t>& owner_bytes = {});
  /// Nothing where there is none. Errors: io.
  Result<std::optional<EnvironmentRecord>> find(const Digest& id) const;
  /// In the order of arrival. Errors: io.
  Result<std::vector<EnvironmentRecord>> list() const;
  /// Errors: not_found, where there is none or its file was damaged: then it is gone and may be added again.
  Result<Blob> bytes(const Digest& id);
  /// Names one that has no name. Errors: io.
  Status name(const Digest& id, const std::string& name);
  /// Removing what is not there is no error.
  Status remove(const Digest& id);

 private:
  Environments(Database& database, std::unique_ptr<Blobs> files) : database_(database), files_(std::move(files)) {}

  Database& database_;
  const std::unique_ptr<Blobs> files_;
  std::mutex changing_;  ///< a file that is put must not go before it has its row
};

}  // namespace photond
