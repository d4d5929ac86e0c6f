#pragma once

#include <optional>

#include "core/trace/bsdf.h"
#include "core/trace/layer.h"

namespace photond {

/// The lobes of a Bsdf at which photons are gathered, evaluated for eight directions at a time.
class Bsdf8 {
 public:
  /// `mask`: without the glass lobe.
  Bsdf8(const Bsdf& bsdf, LobeMask mask);

  /// What Bsdf::eval returns for radiance of these lobes and each of eight unit directions.
  Vec3x8 eval(const Vec3x8& wi) const;

 private:
  Vec3x8 reflection(const Vec3x8& wi) const;

  Frame frame_;
  Vec3 ng_, wo_;
  Rgb diffuse_{0};             // f of the base, but for what the layer takes of wi
  Rgb f0_{0}, f90_{0};         // 0 without the reflection lobe
  float alpha_sq_ = 1;
  float lambda_out_ = 0;
  bool reflects_ = false;
  std::optional<LayerTransmission> layer_;
};

}  // namespace photond
