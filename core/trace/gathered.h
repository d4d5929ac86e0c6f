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

/// Gloss: reflections too narrow for all light to be gathered there, not narrow enough to be mirrors. Caustic light
/// to it may be shared between photons and paths that go on (PreparedScene::shares_gloss). Not where a surface
/// transmits.
inline LobeMask gloss_lobes(const Bsdf& bsdf) {
  if ((bsdf.lobes() & kGlassLobe) != 0) return kNoLobe;
  return bsdf.lobes() & kReflectionLobe & ~gathered_lobes(bsdf) & ~bsdf.delta_lobes();
}

}  // namespace photond
