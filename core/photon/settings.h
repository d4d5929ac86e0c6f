#pragma once

#include <compare>
#include <cstdint>

namespace photond {

/// Exactly what changes a photon map beside the scene; part of its cache key.
struct PhotonSettings {
  std::uint32_t photons_per_pass = 262'144;  ///< paths emitted, 1 … 100'000'000
  std::uint64_t seed = 0;
  auto operator<=>(const PhotonSettings&) const = default;
};

}  // namespace photond
