#pragma once

#include "core/trace/bsdf.h"

namespace photond {

/// From this GGX α upwards a reflection lobe takes part in photon density estimation; below it the path is followed
/// on both sides. Any value gives the same limit: the lobes are split, not the light.
inline constexpr float kGatherAlpha = 0.25f;

/// The lobes at which photons are gathered.
inline LobeMask gathered_lobes(const Bsdf& bsdf) {
  LobeMask mask = kDiffuseLobe;
  if (bsdf.alpha() >= kGatherAlpha) mask |= kReflectionLobe;
  return mask & bsdf.lobes();
}

}  // namespace photond
