#pragma once

#include <compare>
#include <cstdint>

namespace photond {

/// Which photons of the emitted paths are kept.
enum class PhotonSet : std::uint8_t {
  all,
  caustic,   ///< LS⁺D, for merging with paths from the eye: paths of photons end at the first gathered lobe, and nothing
             ///< is emitted by an environment whose light is left to the eye's paths
};

/// Exactly what changes a photon map beside the scene; part of its cache key.
struct PhotonSettings {
  /// Paths emitted, 1 … 100'000'000; fewer where they are directed (PreparedScene::directed_share).
  std::uint32_t photons_per_pass = 262'144;
  std::uint64_t seed = 0;
  auto operator<=>(const PhotonSettings&) const = default;
};

}  // namespace photond
