#pragma once

#include <algorithm>
#include <atomic>
#include <compare>
#include <cstdint>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "core/base/parallel.h"
#include "core/render/settings.h"
#include "server/jobs/map_cache.h"
#include "server/jobs/scene_library.h"
#include "server/jobs/scheduler.h"

namespace photond {

/// Which photon maps are to be there before a job asks for them: those of the method's first passes, and the guide.
struct PrewarmSpec {
  Digest scene;  ///< of the file
  PhotonSettings photons;
  Method method = Method::progressive;
  std::uint32_t passes = 1;
  auto operator<=>(const PrewarmSpec&) const = default;
};

/// The keys of a specification; `content` is the scene's digest without cameras and names.
std::vector<MapKey> prewarm_keys(const PrewarmSpec& spec, const Digest& content);

/// Builds what of a specification is missing, a map in every slice.
class Prewarm : public Slices {
 public:
  /// `keys` are those of the specification, `owner` the id of who asks; maps of more than `max_bytes` are not built. The
  /// references must outlive the object.
  Prewarm(const PrewarmSpec& spec, std::vector<MapKey> keys, std::string owner, SceneLibrary& scenes, MapCache& maps,
          const Workers& workers, std::uint64_t max_bytes)
      : spec_(spec),
        owner_(std::move(owner)),
        keys_(std::move(keys)),
        scenes_(scenes),
        maps_(maps),
        max_bytes_(max_bytes),
        execution_(workers.execution(stop_.get_token())),
        missing_(keys_.rbegin(), keys_.rend()) {}

  bool step() override;
  std::string owner() const override { return owner_; }
  bool ended() const { return ended_; }
  /// Whether this is to build the map of `key`, where it is not there.
  bool names(const MapKey& key) const { return std::find(keys_.begin(), keys_.end(), key) != keys_.end(); }
  /// Ends what computes now within a second; what has been built stays.
  void cancel() { stop_.request_stop(); }

 private:
  Status advance();

  const PrewarmSpec spec_;
  const std::string owner_;
  const std::vector<MapKey> keys_;
  SceneLibrary& scenes_;
  MapCache& maps_;
  const std::uint64_t max_bytes_;
  std::stop_source stop_;
  const Execution execution_;
  SceneLibrary::Prepared scene_;
  std::vector<MapKey> missing_;  ///< the next one last
  std::atomic<bool> ended_{false};
};

}  // namespace photond
