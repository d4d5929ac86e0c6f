#pragma once

#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "core/scene/environment.h"
#include "server/jobs/disk_room.h"
#include "server/jobs/shared_cache.h"
#include "server/store/environments.h"
#include "server/store/keys.h"
#include "server/store/records.h"

namespace photond {

/// The environment maps the service knows. Files are kept in the store; maps are decoded when first needed, once, and
/// kept within a budget.
class EnvironmentLibrary {
 public:
  /// The references must outlive the library.
  EnvironmentLibrary(Environments& store, DiskRoom& room, std::uint64_t cache_bytes)
      : store_(store), room_(room), decoded_(cache_bytes) {}

  struct Added {
    EnvironmentRecord environment;
    bool fresh = false;  ///< not known before
  };
  /// Decodes and stores an upload; nothing is stored where that fails. `name` is as of a scene. Errors: those of
  /// read_environment and of the store, limit_exceeded at "disk" (also of what the owner may have), cancelled.
  Result<Added> add(std::vector<std::byte> bytes, const std::string& name, const Owner& owner, std::stop_token stop);

  /// Errors: io.
  Result<std::vector<EnvironmentRecord>> list() const { return store_.list(); }
  /// Errors: not_found, io.
  Result<EnvironmentRecord> find(const Digest& id) const;
  Status remove(const Digest& id) { return store_.remove(id); }

  /// What a job asks for. Errors: not_found with `where` "/environment/id", io, cancelled.
  Result<Environment> environment(const EnvironmentChoice& choice, std::stop_token stop);

 private:
  struct Decoded {
    std::shared_ptr<const EnvironmentMap> map;
    std::uint64_t memory_bytes = 0;
  };
  Result<std::shared_ptr<const Decoded>> decode(const std::vector<std::byte>& bytes, const std::stop_token& stop);

  Environments& store_;
  DiskRoom& room_;
  SharedCache<Digest, Decoded> decoded_;
  std::timed_mutex decoding_;  ///< it takes several times the file's size in memory
};

}  // namespace photond
