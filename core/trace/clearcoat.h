#pragma once

#include "core/math/frame.h"
#include "core/trace/microfacet.h"

namespace photond {

/// A colourless layer of index 1.5 over all else that a surface point scatters, with a normal of its own, for a fixed
/// direction `wo` (KHR_materials_clearcoat): a GGX layer of Schlick reflectance, which lets through what it does not
/// reflect.
class Clearcoat {
 public:
  /// `amount` in (0, 1] scales its reflectance. `normal`: unit, on the side of `wo`; `wo`: unit, away from the surface.
  /// `beyond`: it covers the other side of the surface, and wo is inside of what it covers.
  Clearcoat(float amount, float alpha, const Vec3& normal, const Vec3& wo, bool beyond);

  bool beyond() const { return beyond_; }
  bool smooth() const { return alpha() < kSmoothAlpha; }
  float alpha() const { return facets_.least(); }
  const Vec3& normal() const { return frame_.n; }

  /// Share of light from or to `w` (world) that crosses it.
  float through(const Vec3& w) const;
  /// The same of wo.
  float through() const { return through_out_; }
  /// The same of a direction of that cosine to its normal.
  float through(float cosine) const;

  /// Probability with which smooth coat reflects wo; a measure of how much any does.
  float reflectance() const { return fresnel(wo_.z); }
  /// f·cos towards `wi` (world), the cosine by its own normal, unless it is smooth.
  float scattered(const Vec3& wi) const;
  /// Density per solid angle with which `sample` finds `wi`.
  float pdf(const Vec3& wi) const;
  /// A direction (world) by visible normals; below the horizon where nothing is reflected.
  Vec3 sample(const Vec2& u) const;
  /// Where it mirrors wo to (world).
  Vec3 mirrored() const { return frame_.to_world({-wo_.x, -wo_.y, wo_.z}); }
  /// The same on a surface with another normal.
  Clearcoat turned(const Vec3& normal) const;

 private:
  friend class Bsdf8;

  static constexpr float kF0 = 0.04f;   // of index 1.5

  float fresnel(float cos_h) const { return amount_ * (kF0 + (1 - kF0) * schlick_weight(cos_h)); }

  Frame frame_;
  Vec3 wo_;              // local
  Ggx facets_;
  float amount_;
  float through_out_;
  bool beyond_;
};

}  // namespace photond
