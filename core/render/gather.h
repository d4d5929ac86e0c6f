#pragma once

#include "core/render/camera_path.h"

namespace photond {

/// The squared widest radius of a gather at `position` by Technique::density or merge: as asked; else it holds enough
/// photons for little noise within a pass, but is no wider than the narrowest scale resolves footprints.
float widest_radius_sq(const RadianceSettings& settings, const Bandwidth& bandwidth, const Vec3& position,
                       float footprint);

/// Technique::density: adds what all photons bring to the gathered lobes of `surface`, times the path's throughput.
void gather_density(const RadianceSettings& settings, const CameraPath& path, const SurfacePoint& surface,
                    const Bsdf& bsdf, const Lobes& lobes, ScaleEstimate& sum);

/// Adds the photons' share of caustic light to the lobes in `mask`, by which the path goes on with probability `share`,
/// times its throughput; only the widest estimate where it has scattered before. Returns how light is shared with the
/// path that goes on.
Merge gather_caustic(const RadianceSettings& settings, const Lights& lights, const CameraPath& path,
                     const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask, float share, ScaleEstimate& sum);

/// Radiance by the k nearest photons of `map` to the lobes in `mask` of `surface`.
Rgb gather_nearest(const RadianceSettings& settings, const PhotonMap& map, const SurfacePoint& surface,
                   const Bsdf& bsdf, LobeMask mask);

/// Technique::nearest: radiance by all photons to the gathered lobes of `surface`, to the diffuse one by the irradiance
/// computed beforehand where there is any near.
Rgb gather_all(const RadianceSettings& settings, const SurfacePoint& surface, const Bsdf& bsdf, const Lobes& lobes);

}  // namespace photond
