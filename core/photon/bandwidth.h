#pragma once

#include <memory>
#include <vector>

#include "core/photon/photon_maps.h"

namespace photond {

/// The photon density of a small pilot map as a function of position: what chooses the radius of a gather, never the
/// photons that are gathered. It belongs to the scene and the settings of the photons, not to a camera.
class Bandwidth {
 public:
  Bandwidth() = default;
  /// `map` is one of `pilot`; `growth` is the number of paths of a pass over that of the pilot.
  Bandwidth(std::shared_ptr<const PhotonMaps> pilot, const PhotonMap* map, float growth, const Execution& execution);

  /// The squared radius that holds about `photons` photons of one pass; 0 where the pilot is too small to tell.
  float radius_sq(const Vec3& point, float photons) const;

 private:
  std::shared_ptr<const PhotonMaps> pilot_;   // keeps map_ alive
  const PhotonMap* map_ = nullptr;
  std::vector<float> density_;   // photons per pass and m² at each photon of the pilot
};

}  // namespace photond
