#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "core/math/lanes.h"
#include "core/math/scales.h"
#include "core/photon/guide.h"
#include "core/photon/photon_maps.h"
#include "core/render/camera_sampler.h"
#include "core/trace/enclosing.h"

namespace photond {

/// How indirect light is found at the lobes where photons can be gathered.
enum class Technique : std::uint8_t {
  trace,          ///< all lobes are followed: a path tracer
  merge,          ///< the same, with caustics shared with photons wherever photons can be gathered
  density,        ///< photon density estimates at several radii that do not depend on the photons
  nearest,        ///< photon density estimate from the k nearest
  final_gather,   ///< caustics by `nearest`, the rest by rays whose ends are estimated by `nearest`
};

/// What the radiance along a ray depends on beside the scene.
struct RadianceSettings {
  Technique technique = Technique::trace;
  const PhotonMap* global = nullptr;     ///< indirect light; null for Technique::trace and merge
  const PhotonMap* caustic = nullptr;    ///< null for Technique::trace
  const Irradiance* irradiance = nullptr;   ///< final_gather, nearest: by both maps, read where rays end; null: none
  double emitted = 1;                    ///< PhotonMaps::emitted
  float flux_unit = 1;                   ///< Lights::flux_unit
  const GatherGuide* guide = nullptr;    ///< cuts kernels at edges; density, merge: chooses radii; null: neither
  float pilot_share = 1;                 ///< density, merge: paths of the guide's pilot over those of `maps`
  float radius_sq = 0;                   ///< density, merge: widest, 0 for the guide's; nearest, final_gather: largest
  float shrink = 1;                      ///< density, merge: factor of the guide's radius², falling with the passes
  Vec3 wavelengths{0};                   ///< of the pass (disperse)
  float most_normal_factor = 8;          ///< as in estimate_scales
  float pixel_width = 0;                 ///< density, merge: a pixel's footprint in metres is pixel_width
  float pixel_spread = 0;                ///<   + pixel_spread · the path's length
  std::uint32_t nearest = 64;            ///< k
  std::uint32_t max_depth = 65'536;      ///< bounces of a path
  Medium start;                          ///< the volumes around the rays' origins
  bool apart = false;                    ///< or these lie in volumes of their own, to be found
};

/// The volumes in which a ray from the camera starts.
inline Medium start_of(const PreparedScene& scene, const RadianceSettings& settings, const Ray& ray) {
  return settings.apart ? enclosing(scene.scene, scene.accel, ray.origin) : settings.start;
}

/// An estimate of radiance in W·m⁻²·sr⁻¹.
struct RadianceSample {
  Rgb radiance{0};   ///< with the widest radius where photons take part
  bool truncated = false;   ///< the path was cut after max_depth bounces: the light of longer ones is missing
};

/// The radiance arriving along −direction at the origin of each ray, with the sampler that belongs to it. Unbiased for
/// Technique::trace; otherwise with the bias of the density estimate, which vanishes with the radius (density, merge).
/// The three are of one length; the last bits of a sample may depend on the rays beside it. `bands`, for density and
/// merge: what the narrower radii add to the radiance; of that length, too, or none.
void estimate_incoming(const PreparedScene& scene, const RadianceSettings& settings, std::span<const Ray> rays,
                       std::span<const CameraSampler> samplers, std::span<RadianceSample> samples,
                       std::span<Bands> bands = {});

/// Into what lengths so many samples are to be divided: setting out and the last paths hardly count, but there are enough
/// for many threads.
inline constexpr std::size_t kMostSamplesTogether = 32 * kLanes;
inline std::size_t samples_together(std::size_t samples) {
  return std::clamp<std::size_t>(samples / 64, 8 * kLanes, kMostSamplesTogether) / kLanes * kLanes;
}

}  // namespace photond
