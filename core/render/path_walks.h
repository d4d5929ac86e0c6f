#pragma once

#include <array>

#include "core/render/bounces.h"
#include "core/render/path_lanes.h"

namespace photond {

/// Technique::trace: a path tracer whose paths lie side by side. Where some end, others begin.
class PathWalks {
 public:
  PathWalks(const PreparedScene& scene, const RadianceSettings& settings)
      : scene_(scene), settings_(settings), bounces_(scene, settings) {}

  /// As estimate_incoming.
  void run(std::span<const Ray> rays, std::span<const CameraSampler> samplers, std::span<RadianceSample> samples);

 private:
  // Some of the lanes. Filled without branches: whether a lane belongs, none could predict.
  struct Subset {
    std::array<std::uint32_t, kLanes + 1> lanes;
    std::uint32_t size = 0;

    void add(std::uint32_t lane, bool belongs) {
      lanes[size] = lane;
      size += belongs;
    }
    const std::uint32_t* begin() const { return lanes.data(); }
    const std::uint32_t* end() const { return lanes.data() + size; }
  };

  void begin(std::span<const Ray> rays, std::span<const CameraSampler> samplers);
  void intersect();
  void meet_surfaces();
  void advance();
  void advance_others();
  void add_emissions();
  void add_direct_light();
  void remove(const Subset& ended);

  const PreparedScene& scene_;
  const RadianceSettings& settings_;
  Bounces bounces_;
  PathLanes paths_{};
  std::uint32_t count_ = 0;      // of paths, in the first lanes
  HitLanes hits_;                // what their rays meet
  Subset diffuse_, others_, emitters_;
  std::array<Walk, kLanes> walks_;         // others_ after the bounce
  RayLanes camera_rays_{};       // the next paths to begin, and what they meet
  HitLanes camera_hits_;
  std::size_t traced_ = 0, begun_ = 0;     // of all that there are
};

}  // namespace photond
