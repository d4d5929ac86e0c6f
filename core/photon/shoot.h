#pragma once

#include <cstdint>
#include <vector>

#include "core/photon/photon_maps.h"
#include "core/trace/gathered.h"

namespace photond {

/// What a range of emitted paths leaves behind.
struct PhotonBlock {
  std::vector<Photon> global;
  std::vector<Photon> caustic;
  EnergyLedger ledger;                 ///< not yet divided by the number of emitted paths
  std::uint64_t rays = 0;
  std::uint64_t caustic_rays = 0;      ///< as in PhotonMaps
};

/// Vertices after which a photon path is cut and counted as truncated.
inline constexpr std::uint32_t kMaxPhotonDepth = 65'536;

/// Traces the emitted paths [first, last) of a pass. A pure function of its arguments. Every traced ray is
/// appended to `record` where that is given. The result takes the memory of `spent`, a block that nobody needs.
PhotonBlock shoot(const PreparedScene& scene, const MapKey& key, std::uint64_t first, std::uint64_t last,
                  std::vector<Ray>* record = nullptr, PhotonBlock spent = {});

}  // namespace photond
