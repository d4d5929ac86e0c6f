#pragma once

#include <cmath>

#include "core/math/scales.h"
#include "core/photon/photon_map.h"
#include "core/photon/reach.h"
#include "core/trace/bsdf.h"
#include "core/trace/specular.h"

namespace photond {

/// Radiance by photon density at the radii r, r/2, …, r/2^kBands, in W·m⁻²·sr⁻¹.
struct ScaleEstimate {
  Rgb widest{0};   ///< L(r)
  Bands bands;     ///< what the narrower radii add
};

/// The multiple importance sampling of caustic light that photons bring and that paths from the eye find, too, by
/// following a gathered lobe, or gloss, and then the same chain of mirrors and glass to an extended light.
///
/// The densities of the two are ρ : 1, ρ = q p(ω)/|cos| · G/(N π r²), where a path goes on from here with probability q
/// and density p per solid angle, N paths are emitted, r is *the* radius of the gather, and G is the étendue of the
/// photon's path: Liouville's theorem keeps it along the chain up to n². So both sides know ρ without each other, and
/// their shares are 1/(1 + ρ) of the photon and ρ/(1 + ρ) of the path. Of light without étendue paths find nothing.
struct Merge {
  float per_etendue = 0;   ///< q/(N π r²); 0: photons take all

  /// ρ of light from `wi` through the lobes in `mask`; `etendue` as it is at the surface.
  float ratio(const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask, const Vec3& wi, float etendue) const {
    if (etendue == kInfinity) return kInfinity;   // the paths', even where they have no density
    const float cosine = std::abs(glm::dot(wi, surface.ns));
    return cosine > 0 ? per_etendue * etendue * bsdf.pdf(wi, mask) / cosine : 0;
  }
};

/// Adds to `sum` the radiance leaving `surface` towards the `wo` of `bsdf` by the photons of `map` within `radius_sq`
/// > 0, through the lobes in `mask`, times `scale` (the path's throughput over the number of emitted paths). Kernels
/// are Epanechnikov's, cut to `reach` and renormalized. Photons from behind the surface or of a very different
/// orientation do not count. Bias of each scale: O(r²), O(r) at the boundary of the reach. With `merge`, each photon
/// counts by its share. `most_normal_factor`: the bound for this pass.
void estimate_scales(const PhotonMap& map, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask,
                     const Reach& reach, float radius_sq, const Rgb& scale, ScaleEstimate& sum, const Merge& merge = {},
                     float most_normal_factor = photond::most_normal_factor(0));

/// Flux per m² that arrives at a surface through `position` with the geometric unit `normal`, by the same kernel and
/// photons; to be divided by the number of emitted paths.
Rgb estimate_irradiance(const PhotonMap& map, const Vec3& position, const Vec3& normal, const Reach& reach,
                        float radius_sq);

}  // namespace photond
