#pragma once

#include <optional>
#include <span>

#include "core/photon/photon_map.h"
#include "core/photon/edges.h"

namespace photond {

/// Irradiance computed beforehand at many places, and read at the nearest of them [Christensen 1999]. Immutable and
/// independent of the camera.
///
/// The places are those of other photons than the ones that are counted: so they are dense where light is, but tell
/// nothing of how many photons are counted around them. At the photons' own places there would be one too many at each,
/// where its kernel is highest (1/32 of k = 64), and without that one the estimate would still be low where places are far
/// apart, which is where most look-ups end.
class Irradiance {
 public:
  /// Of the photons k of the estimate at a place: no setting, so that all pictures share it.
  static constexpr std::uint32_t kNearest = 64;

  Irradiance() = default;
  /// The irradiance by the photons of all `maps` of `emitted` paths together, at the places of all photons of `at`. No
  /// photon beyond `reach` (m) of a place counts. The bits do not depend on the execution. Undefined once it is cancelled.
  Irradiance(std::span<const PhotonMap* const> maps, double emitted, std::span<const PhotonMap* const> at,
             const Edges& edges, float reach, const Execution& execution);
  /// Of what another one has told.
  Irradiance(PhotonMap places, float reach) : places_(std::move(places)), reach_(reach) {}

  /// W/m² at the nearest place within reach of `position` whose geometric normal is like the unit vector `normal` and
  /// that lies behind none of the `edges`; of equally near ones at that which comes first. Nothing where there is none.
  std::optional<Rgb> at(const Edges& edges, const Vec3& position, const Vec3& normal) const;
  /// The number of that place.
  std::optional<std::uint32_t> nearest(const Edges& edges, const Vec3& position, const Vec3& normal) const;

  /// Each place as a photon: position, normal, and as its flux the irradiance.
  const PhotonMap& places() const { return places_; }
  float reach() const { return reach_; }
  std::uint64_t memory_bytes() const { return places_.memory_bytes(); }

 private:
  PhotonMap places_;
  float reach_ = 0;
};

}  // namespace photond
