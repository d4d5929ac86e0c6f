#pragma once

#include <memory>
#include <optional>
#include <span>

#include "core/base/large_array.h"
#include "core/photon/photon_maps.h"

namespace photond {

/// The photon density of a small pilot map as a function of position: what chooses the radius of a gather, never the
/// photons that are gathered. It belongs to the scene and the seed, not to a camera.
class Bandwidth {
 public:
  Bandwidth() = default;
  /// `map` is one of `pilot`.
  Bandwidth(std::shared_ptr<const PhotonMaps> pilot, const PhotonMap* map, const Execution& execution);
  /// With densities that were measured before, used where they lie. Nothing where their number is not the map's.
  static std::optional<Bandwidth> over(std::shared_ptr<const PhotonMaps> pilot, const PhotonMap* map,
                                       std::span<const float> densities, std::shared_ptr<const void> owner);

  /// The squared radius that holds about `photons` photons of the pilot; 0 where the pilot is too small to tell.
  float radius_sq(const Vec3& point, float photons) const;

  /// Photons per m² at each photon of the pilot; empty where the pilot is too small to tell.
  std::span<const float> densities() const { return {density_.get(), count_}; }
  /// The median of them; 0 where there are none.
  float median() const;

 private:
  std::shared_ptr<const PhotonMaps> pilot_;   // keeps map_ alive
  const PhotonMap* map_ = nullptr;
  std::uint32_t count_ = 0;
  LargeArray<float> density_;
};

}  // namespace photond
