#pragma once

#include "core/trace/accel.h"
#include "core/trace/cover.h"

namespace photond {

/// Those of several rays that may meet anything in a cover.
class CrossingRays {
 public:
  /// Of the first `count`, those that cross it before `t_max`; in doubt they do.
  CrossingRays(const Cover& cover, const RayLanes& all, const float (&t_max)[kLanes], std::uint32_t count);

  /// They, one after the other, up to `t_max`.
  const RayLanes& rays() const { return rays_; }
  std::uint32_t size() const { return size_; }

  /// Puts hits among what they have met where the rays were.
  void put(const HitLanes& met, HitLanes& hits) const;
  void put(const std::uint8_t (&met)[kLanes], std::uint8_t (&hidden)[kLanes]) const;

 private:
  RayLanes rays_;
  std::uint32_t size_ = 0;
  std::uint32_t lane_[kLanes];   // where each of them was
};

}  // namespace photond
