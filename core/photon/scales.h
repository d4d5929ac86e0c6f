#pragma once

#include "core/math/scales.h"
#include "core/photon/photon_map.h"
#include "core/photon/reach.h"
#include "core/trace/bsdf.h"

namespace photond {

/// Radiance by photon density at the radii r, r/2, …, r/2^kBands, in W·m⁻²·sr⁻¹.
struct ScaleEstimate {
  Rgb widest{0};   ///< L(r)
  Bands bands;     ///< what the narrower radii add
};

/// Adds to `sum` the radiance leaving `surface` towards the `wo` of `bsdf` by the photons of `map` within `radius_sq`
/// > 0, through the lobes in `mask`, times `scale` (the path's throughput over the number of emitted paths). Kernels
/// are Epanechnikov's, cut to `reach` and renormalized. Photons from behind the surface or of a very different
/// orientation do not count. Bias of each scale: O(r²), O(r) at the boundary of the reach.
void estimate_scales(const PhotonMap& map, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask,
                     const Reach& reach, float radius_sq, const Rgb& scale, ScaleEstimate& sum);

}  // namespace photond
