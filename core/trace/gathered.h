#pragma once

#include "core/math/rng.h"
#include "core/trace/bsdf.h"

namespace photond {

/// From this GGX α upwards a reflection lobe takes part in photon density estimation; below it the path is followed
/// on both sides. Any value gives the same limit: the lobes are split, not the light.
inline constexpr float kGatherAlpha = 0.25f;

/// The lobes at which photons are gathered.
inline LobeMask gathered_lobes(const Bsdf& bsdf) {
  return ((kDiffuseLobe | kSheenLobe) & bsdf.lobes()) | bsdf.reflections_from(kGatherAlpha);
}

/// Gloss: reflections too narrow for all light to be gathered there, not narrow enough to be mirrors. Caustic light
/// to it may be shared between photons and paths that go on (PreparedScene::shares_gloss). Not where a surface
/// transmits.
inline LobeMask gloss_lobes(const Bsdf& bsdf) {
  if ((bsdf.lobes() & kGlassLobe) != 0) return kNoLobe;
  return bsdf.reflections_from(kSmoothAlpha) & ~bsdf.reflections_from(kGatherAlpha);
}

/// Chance decides, in proportion to what gathered and other lobes scatter, which of them the light is of that both do; the
/// weight becomes that of those lobes alone. True: the gathered ones.
inline bool settle(const Rgb& of_gathered, const Rgb& of_others, Rng& rng, Rgb& weight) {
  const Rgb all = of_gathered + of_others;
  const float sum = all.x + all.y + all.z;
  const float p = (of_gathered.x + of_gathered.y + of_gathered.z) / sum;
  const bool settled = rng.next() < p;
  const Rgb part = settled ? of_gathered / p : of_others / (1 - p);
  for (int c = 0; c < 3; ++c) weight[c] *= all[c] > 0 ? part[c] / all[c] : 0;
  return settled;
}

/// Whether what was sampled from all lobes was scattered by `gathered` ones. Where others scatter that way, too, `settle`
/// decides: the lobe that was drawn does not tell, since where lobes overlap, each is drawn for the light of both.
inline bool settle_gathered(const Bsdf& bsdf, LobeMask gathered, Rng& rng, BsdfSample& sample) {
  const LobeMask others = bsdf.lobes() & ~gathered & ~bsdf.delta_lobes();
  const bool drawn = (sample.lobe & gathered) != 0;
  if (sample.delta || gathered == kNoLobe || others == kNoLobe) return drawn;
  const Rgb of_gathered = bsdf.eval(sample.wi, gathered, Transport::flux);
  const Rgb of_others = bsdf.eval(sample.wi, others, Transport::flux);
  if (is_black(of_gathered + of_others)) return drawn;
  const bool settled = settle(of_gathered, of_others, rng, sample.weight);
  sample.lobe = settled ? gathered : others;
  return settled;
}

}  // namespace photond
