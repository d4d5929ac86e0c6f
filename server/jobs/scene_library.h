#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <semaphore>
#include <span>
#include <string>
#include <vector>

#include "core/base/parallel.h"
#include "core/render/plan.h"
#include "core/scene/report.h"
#include "core/trace/prepare.h"
#include "server/jobs/disk_room.h"
#include "server/jobs/environment_library.h"
#include "server/jobs/shared_cache.h"
#include "server/store/keys.h"
#include "server/store/store.h"

namespace photond {

/// What is said of a scene: its report, and what would be activated for a picture with default settings.
struct SceneSummary {
  SceneReport report;
  std::vector<Camera> cameras;
  Plan plan;
  std::uint64_t memory_bytes = 0;  ///< not exact: bounds how many are kept
};

/// Every *.glb of a folder, in alphabetical order. Errors: io.
Result<std::vector<std::filesystem::path>> sample_files(const std::string& folder);

/// The scenes the service knows. Files are kept in the store; what is derived from them is made when first
/// needed, once, and kept within a budget.
class SceneLibrary {
 public:
  using Prepared = std::shared_ptr<const PreparedScene>;
  using Summary = std::shared_ptr<const SceneSummary>;

  /// The references must outlive the library.
  SceneLibrary(Store& store, EnvironmentLibrary& environments, DiskRoom& room, const Workers& workers,
               std::uint64_t cache_bytes)
      : store_(store), environments_(environments), room_(room), workers_(workers), prepared_(cache_bytes), summaries_(kSummaryBytes) {}

  /// Offers scenes, named by their files, without parsing them. Errors: io.
  Status add_samples(std::span<const std::filesystem::path> files);

  struct Added {
    SceneRecord scene;
    bool fresh = false;  ///< not known before
  };
  /// Parses, prepares and stores an upload; nothing is stored where that fails. `name` is for people, and may be empty;
  /// a scene that is known keeps the one it has, and one without gets it only from its owner or an admin. Errors: those
  /// of read_gltf and read_archive, limit_exceeded at "disk" (also of what the owner may have), unsupported for other
  /// media types, cancelled.
  Result<Added> add(std::vector<std::byte> bytes, const std::string& media_type, const std::string& name,
                    const Owner& owner, std::stop_token stop);

  /// Errors: not_found, or why the scene cannot be used.
  Result<Summary> summary(const Digest& id, std::stop_token stop);
  /// The scene, lit from around as `environment` says. Errors: not_found and why it cannot be used, with `where`
  /// "/scene"; those of the environment; cancelled.
  Result<Prepared> prepared(const Digest& id, const std::optional<EnvironmentChoice>& environment,
                            const Execution& execution);
  /// In its own environment.
  Result<Prepared> prepared(const Digest& id, const Execution& execution) { return prepared(id, std::nullopt, execution); }

 private:
  static constexpr std::uint64_t kSummaryBytes = 64 << 20;

  Result<Prepared> prepare_bytes(const Blob& bytes, const std::string& media_type,
                                 const std::optional<Environment>& environment, const Execution& execution);
  Result<Summary> summarize(const Prepared& scene, const Execution& execution);

  Store& store_;
  EnvironmentLibrary& environments_;
  DiskRoom& room_;
  const Workers& workers_;
  SharedCache<Digest, PreparedScene> prepared_;
  SharedCache<Digest, SceneSummary> summaries_;
  std::counting_semaphore<2> parsing_{2};  ///< parsing takes several times the file's size in memory
};

/// The camera a job asks for. Errors: not_found with `where` "/camera".
Result<Camera> choose_camera(const std::vector<Camera>& cameras, const CameraChoice& choice);

}  // namespace photond
