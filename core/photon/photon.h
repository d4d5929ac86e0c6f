#pragma once

#include <cstdint>

#include "core/math/types.h"
#include "core/photon/packed_flux.h"

namespace photond {

/// One hit of an emitted path: 32 bytes, moved as one, until it is indexed.
struct alignas(32) Photon {
  Vec3 position{0};
  std::uint32_t direction = 0;   ///< octahedral: unit, away from the surface, where the photon came from
  std::uint32_t normal = 0;      ///< ten bits a component: geometric normal on the side the photon came from
  PackedFlux flux;               ///< W, to be divided by the number of emitted paths
  float etendue = 0;             ///< of the path's pencil in m²·sr, as EmissionSample::etendue; of caustic photons only
};

}  // namespace photond
