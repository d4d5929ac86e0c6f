#pragma once

#include "core/math/rng.h"
#include "core/trace/bsdf.h"

namespace photond {

/// A photon's continuation.
struct FluxSample {
  Vec3 wi{0};                ///< world, away from the surface
  Rgb weight{0};             ///< of its flux
  bool transmitted = false;  ///< wi is on the other geometric side
  bool by_gathered = false;  ///< scattered by the lobes at which photons are gathered
};

/// How a photon that came from `wi` leaves a surface whose `bsdf` is that for `wi`. False where it is absorbed.
///
/// The exact adjoint of what paths from the eye do [Veach 1997, §5.3]. They bend shading normals towards where they come
/// from, and so see a surface from below the horizon of its shading normal, too, as if it grazed them: photons leave that
/// way as well, and what they carry is told by the BSDF as a path sees it that arrives along their way. Mirrors and smooth
/// glass send paths about the true normal where the shading normal would send them through the surface: photons leave
/// about that as well where paths arrive so, and about the shading normal only where they do not. What grows without bound
/// where light grazes the true surface is bounded by `most_normal_factor`.
bool scatter_flux(const Scene& scene, const SurfacePoint& surface, const Bsdf& bsdf, const Vec3& wi,
                  float most_normal_factor, Rng& rng, FluxSample& out);

}  // namespace photond
