#pragma once

#include <compare>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "core/base/parallel.h"
#include "server/jobs/map_cache.h"
#include "server/jobs/scene_library.h"
#include "server/jobs/scheduler.h"

namespace photond {

/// Which photon maps are to be there before a job asks for them: those of the first passes, and the guide.
struct PrewarmSpec {
  Digest scene;  ///< of the file
  PhotonSettings photons;
  std::uint32_t passes = 1;
  auto operator<=>(const PrewarmSpec&) const = default;
};

/// The keys of a specification; `content` is the scene's digest without cameras and names.
std::vector<MapKey> prewarm_keys(const PrewarmSpec& spec, const Digest& content);

/// Builds what of a specification is missing, a map in every slice.
class Prewarm : public Slices {
 public:
  /// The references must outlive the object.
  Prewarm(const PrewarmSpec& spec, SceneLibrary& scenes, MapCache& maps, const Workers& workers, std::stop_token stop)
      : spec_(spec), scenes_(scenes), maps_(maps), execution_(workers.execution(std::move(stop))) {}

  bool step() override;
  bool ended() const { return ended_; }

 private:
  Status advance();

  const PrewarmSpec spec_;
  SceneLibrary& scenes_;
  MapCache& maps_;
  Execution execution_;
  SceneLibrary::Prepared scene_;
  std::vector<MapKey> missing_;  ///< the next one last
  std::atomic<bool> ended_{false};
};

}  // namespace photond
