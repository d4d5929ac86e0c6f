#pragma once

#include <span>

#include "core/render/radiance.h"

namespace photond {

/// Light that reaches some samples unless something is in its way. The rays that find out are traced several at a time.
class ShadowRays {
 public:
  explicit ShadowRays(const Accel& accel) : accel_(accel) {}

  /// From now on light belongs to these samples.
  void begin(std::span<RadianceSample> samples) { samples_ = samples; }

  /// Adds `light` to the radiance of one of the samples, now or when `trace` is called, unless it is black or anything lies
  /// along the ray.
  void add(std::uint32_t sample, const Ray& ray, const Rgb& light) {
    rays_.set(size_, ray);
    light_[size_] = light;
    sample_[size_] = sample;
    size_ += !is_black(light);   // which no branch could predict
    if (size_ == kLanes) trace();
  }

  void trace() {
    std::uint8_t hidden[kLanes];
    accel_.occluded(rays_, size_, hidden);
    for (std::uint32_t i = 0; i < size_; ++i) {
      if (hidden[i] == 0) samples_[sample_[i]].radiance += light_[i];
    }
    size_ = 0;
  }

 private:
  const Accel& accel_;
  std::span<RadianceSample> samples_;
  std::uint32_t size_ = 0;
  RayLanes rays_{};   // packets are filled up with whatever is there
  Rgb light_[kLanes];
  std::uint32_t sample_[kLanes];
};

}  // namespace photond
