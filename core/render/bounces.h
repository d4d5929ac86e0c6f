#pragma once

#include <vector>

#include "core/photon/scales.h"
#include "core/render/camera_path.h"
#include "core/render/camera_sampler.h"
#include "core/render/shadow_rays.h"

namespace photond {

/// One path from the camera on its way through the scene.
struct Walk {
  CameraPath path;
  CameraSampler rng;
  std::uint32_t sample = 0;   ///< where its light belongs
};

/// What paths from the camera find where they meet surfaces or leave the scene, and how they go on: any material, any
/// technique, one path at a time.
class Bounces {
 public:
  Bounces(const PreparedScene& scene, const RadianceSettings& settings)
      : shadows(scene.accel), scene_(scene), settings_(settings) {}

  /// From now on light belongs to these samples, what photons bring to these, which may be none for Technique::trace.
  void begin(std::span<RadianceSample> samples, std::span<ScaleEstimate> gathered) {
    samples_ = samples;
    gathered_ = gathered;
    shadows.begin(samples);
  }

  /// From the ray's end, on `surface`, off it again; false where the path ends.
  bool advance(Walk& walk, const Hit& hit, SurfacePoint surface);
  /// Adds light that the path meets: at the end of its ray, or where that has none.
  void add_emission(const Walk& walk, const SurfacePoint& surface, float distance);
  void add_environment(const Walk& walk);

  ShadowRays shadows;             ///< to be traced before the samples are complete
  std::vector<Walk> branches;     ///< paths that began at others and wait to be traced

 private:
  // How light is shared with a path that goes on: by a gathered lobe, or by gloss.
  struct Shares {
    Merge gathered, gloss;
    bool at_gloss = false;
  };

  Technique technique(const CameraPath& path) const;
  bool shares_gloss(const CameraPath& path) const;
  void add(const Walk& walk, const Rgb& light) { samples_[walk.sample].radiance += walk.path.throughput * light; }
  Merge add_indirect(Walk& walk, const SurfacePoint& surface, const Bsdf& bsdf, const Lobes& lobes);
  void gather(Walk& walk, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask);
  bool follow(Walk& walk, const SurfacePoint& surface, const Bsdf& bsdf, const Lobes& lobes, const Shares& shares);
  bool follow_both(Walk& walk, const SurfacePoint& surface, const Bsdf& bsdf, float reflected);
  Walk& branch_off(Walk& walk);

  const PreparedScene& scene_;
  const RadianceSettings& settings_;
  std::span<RadianceSample> samples_;
  std::span<ScaleEstimate> gathered_;
};

}  // namespace photond
