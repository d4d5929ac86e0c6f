#pragma once

#include <cstdint>

#include "core/photon/photon_maps.h"
#include "server/jobs/shared_cache.h"

namespace photond {

/// Photon maps shared by all jobs; a MapKey holds no camera, size or radius.
using MapCache = SharedCache<MapKey, PhotonMaps>;

/// One job's use of the cache. A progressive job asks for a new map in every pass, which would flush the maps
/// of everybody else: so each job may keep only its first passes, up to a quarter of the budget. What is in
/// the cache already it may always use; what it builds later is dropped after the pass.
class MapUse {
 public:
  explicit MapUse(MapCache& cache) : cache_(cache) {}

  /// The maps of `key`, found or built; counted as a hit or a miss.
  Result<std::shared_ptr<const PhotonMaps>> get(const PreparedScene& scene, const MapKey& key,
                                                const Execution& execution) {
    const bool keep = kept_bytes_ < cache_.budget_bytes() / 4;
    const auto build = [&] { return build_photon_maps(scene, key, execution); };
    auto answer = cache_.get_or_build(key, build, execution.stop, keep);
    if (!answer) return answer.error();
    ++(answer->hit ? hits_ : misses_);
    if (keep && !answer->hit) kept_bytes_ += answer->value->memory_bytes;
    return std::move(answer->value);
  }

  std::uint64_t hits() const { return hits_; }
  std::uint64_t misses() const { return misses_; }

 private:
  MapCache& cache_;
  std::uint64_t kept_bytes_ = 0;
  std::uint64_t hits_ = 0;
  std::uint64_t misses_ = 0;
};

}  // namespace photond
