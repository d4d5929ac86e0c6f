#pragma once

#include <cstdint>

#include "core/math/types.h"

namespace photond {

/// One hit of an emitted path: 36 bytes until it is indexed.
struct Photon {
  Vec3 position{0};
  std::uint32_t direction = 0;   ///< octahedral: unit, away from the surface, where the photon came from
  std::uint32_t normal = 0;      ///< ten bits a component: geometric normal on the side the photon came from
  Rgb flux{0};                   ///< W, to be divided by the number of emitted paths
  float etendue = 0;             ///< of the path's pencil in m²·sr, as EmissionSample::etendue; of caustic photons only
};

}  // namespace photond
