#pragma once

#include <memory>

#include "core/photon/bandwidth.h"
#include "core/photon/photon_maps.h"
#include "core/photon/edges.h"

namespace photond {

/// What photon gathers of all passes and cameras have in common: how dense photons lie, and where surfaces end.
/// Immutable.
struct GatherGuide {
  std::shared_ptr<const PhotonMaps> pilot;   ///< whose densities these are
  Bandwidth global;
  Bandwidth caustic;
  Edges edges;
  std::uint64_t memory_bytes = 0;
};

/// Names the guide of a scene: the key of its pilot map, which no rendering's photons come from. All settings with at
/// least 32,768 photons per pass share one.
MapKey guide_key(const Digest& scene, const PhotonSettings& photons);
bool is_guide_key(const MapKey& key);
/// Paths of the pilot over those of a pass, in (0, 1].
float pilot_share(const PhotonSettings& photons);

/// Measures densities with a small map of its own, never with photons of the passes. A pure function of scene and
/// `key` = guide_key(…); errors: cancelled.
Result<std::shared_ptr<const GatherGuide>> build_gather_guide(const PreparedScene& scene, const MapKey& key,
                                                              const Execution& execution);

/// Where a rendering gets its guide from: a cache, or build_gather_guide itself.
using GuideSource = std::function<Result<std::shared_ptr<const GatherGuide>>(const PreparedScene&, const MapKey&,
                                                                             const Execution&)>;

}  // namespace photond
