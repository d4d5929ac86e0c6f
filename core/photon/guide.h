#pragma once

#include <memory>

#include "core/photon/bandwidth.h"
#include "core/photon/photon_maps.h"
#include "core/trace/edges.h"

namespace photond {

/// What photon gathers of all passes and cameras have in common: how dense the photons of a pass lie, and where
/// surfaces end.
struct GatherGuide {
  std::shared_ptr<const PhotonMaps> pilot;   ///< whose densities these are
  Bandwidth global;
  Bandwidth caustic;
  Edges edges;
};

/// Measures densities with a small map of its own, never with photons of the passes. A pure function of its
/// arguments; errors: cancelled.
Result<std::shared_ptr<const GatherGuide>> make_gather_guide(const PreparedScene& scene,
                                                             const PhotonSettings& photons,
                                                             const Execution& execution);

}  // namespace photond
