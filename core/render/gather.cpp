// Jensen 1996: photon maps. Georgiev et al. 2012: merging as a technique of multiple importance sampling.
#include "core/render/gather.h"

#include <cmath>

#include "core/photon/nearest.h"

namespace photond {

namespace {

const GatherGuide& guide_of(const RadianceSettings& settings) {
  static const GatherGuide kNone;
  return settings.guide != nullptr ? *settings.guide : kNone;
}

void add_scales(const RadianceSettings& settings, const PhotonMap& map, float radius_sq, const Rgb& throughput,
                const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask, const Merge& merge, ScaleEstimate& sum) {
  const Rgb scale = throughput * (settings.flux_unit / static_cast<float>(settings.emitted));
  const Reach reach(guide_of(settings).edges, surface.position, surface.ng, std::sqrt(radius_sq));
  estimate_scales(map, surface, bsdf, mask, reach, radius_sq, scale, sum, merge, settings.most_normal_factor);
}

}  // namespace

float widest_radius_sq(const RadianceSettings& settings, const Bandwidth& bandwidth, const Vec3& position,
                       float footprint) {
  static constexpr float kPhotons = 150;
  static constexpr float kFootprints = 24;
  if (settings.radius_sq > 0) return settings.radius_sq;
  const float widest = kFootprints * footprint;
  const float dense = bandwidth.radius_sq(position, kPhotons * settings.pilot_share);
  return settings.shrink * (dense > 0 ? std::min(dense, widest * widest) : widest * widest);
}

void gather_density(const RadianceSettings& settings, const CameraPath& path, const SurfacePoint& surface,
                    const Bsdf& bsdf, const Lobes& lobes, ScaleEstimate& sum) {
  const auto add = [&](const PhotonMap& map, const Bandwidth& bandwidth) {
    if (map.size() == 0) return;
    const float radius_sq = widest_radius_sq(settings, bandwidth, surface.position, path.footprint);
    if (radius_sq > 0) {
      add_scales(settings, map, radius_sq, path.throughput, surface, bsdf, lobes.gathered, {}, sum);
    }
  };
  add(*settings.global, guide_of(settings).global);
  add(*settings.caustic, guide_of(settings).caustic);
}

Merge gather_caustic(const RadianceSettings& settings, const Lights& lights, const CameraPath& path,
                     const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask, float share, ScaleEstimate& sum) {
  const float widest_sq = widest_radius_sq(settings, guide_of(settings).caustic, surface.position, path.footprint);
  if (!(widest_sq > 0)) return {kInfinity};
  // The radius that shares are reckoned with: in the middle of those that the picture may use.
  const float radius_sq = widest_sq / 16;
  Merge merge;
  if (lights.extended()) {
    merge.per_etendue = share / (static_cast<float>(settings.emitted) * kPi * radius_sq);
  }
  const PhotonMap& map = *settings.caustic;
  if (map.size() == 0) return merge;
  if (path.scattered) {
    ScaleEstimate seen;
    add_scales(settings, map, radius_sq, path.throughput, surface, bsdf, mask, merge, seen);
    sum.widest += seen.widest;
  } else {
    add_scales(settings, map, widest_sq, path.throughput, surface, bsdf, mask, merge, sum);
  }
  return merge;
}

Rgb gather_nearest(const RadianceSettings& settings, const PhotonMap& map, const SurfacePoint& surface,
                   const Bsdf& bsdf, LobeMask mask) {
  if (map.size() == 0) return Rgb(0);
  const float radius_sq = nearest_radius_sq(map, surface.position, settings.nearest, settings.radius_sq);
  if (!(radius_sq > 0)) return Rgb(0);
  ScaleEstimate sum;
  add_scales(settings, map, radius_sq, Rgb(1), surface, bsdf, mask, {}, sum);
  return sum.widest;
}

// Only rays that end here read irradiance. As a control variate of paths that go on with probability q, C + [ξ < q](L − C)/q
// at their second surface, it saved nothing: in Cornell boxes, with glass, behind a door ajar, and in closed rooms of albedo
// .5 to .95, a path's own noise from there on is a tenth of the variance to all of it, the best q .8 to 1, and a look-up
// takes as long as the vertices that it saves.
Rgb gather_all(const RadianceSettings& settings, const SurfacePoint& surface, const Bsdf& bsdf, const Lobes& lobes) {
  Rgb sum(0);
  LobeMask rest = lobes.gathered;
  if (settings.irradiance != nullptr && (rest & kDiffuseLobe) != 0) {
    if (const auto irradiance = settings.irradiance->at(guide_of(settings).edges, surface.position, surface.ng)) {
      sum += kInvPi * bsdf.diffuse_albedo() * *irradiance;
      rest &= ~kDiffuseLobe;
    }
  }
  if (rest == kNoLobe) return sum;
  return sum + gather_nearest(settings, *settings.global, surface, bsdf, rest) +
         gather_nearest(settings, *settings.caustic, surface, bsdf, rest);
}

}  // namespace photond
