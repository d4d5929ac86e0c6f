#pragma once

#include <optional>

#include "core/math/float8.h"
#include "core/math/types.h"
#include "core/trace/cosine_nodes.h"

namespace photond {

/// Λ of fibres of one roughness: e to a power that was fitted to it.
struct SheenMasking {
  float a, b, c, d, e;

  explicit SheenMasking(float alpha);
  float exponent(float cosine) const;   ///< of cosines below ½
  float lambda(float cosine) const;
};

/// Fibres on a surface that shine where it is seen or lit at a grazing angle, for a fixed direction `wo`
/// (KHR_materials_sheen): microfacets by the Charlie distribution with the masking fitted to it, which let through what
/// they do not reflect. All directions are local, the normal z, both on one side of the surface.
class Sheen {
 public:
  /// `color` in [0, 1], not black, `roughness` perceptual; `cos_o` that of wo. `beyond`: it covers the other side of
  /// the surface, and wo is inside of what it covers.
  Sheen(const Rgb& color, float roughness, float cos_o, bool beyond);

  bool beyond() const { return beyond_; }
  /// Share of light from or to a direction of that cosine that crosses it, whatever its colour.
  float through(float cosine) const;
  /// The same of wo.
  float through() const { return through_out_; }
  /// Share of light from wo that it reflects.
  Rgb reflectance() const { return color_ * reflected_out_; }
  /// f(wo, wi) in sr⁻¹.
  Rgb eval(const Vec3& wo, const Vec3& wi) const;
  /// The same seen from another direction.
  Sheen turned(float cos_o) const;

 private:
  friend class Sheen8;

  float bound(float cosine) const;

  Rgb color_;
  float alpha_;
  SheenMasking masking_;
  float lambda_out_, bound_out_, reflected_out_, through_out_;
  bool beyond_;
};

/// The same for eight directions at a time.
class Sheen8 {
 public:
  Sheen8(const Sheen& sheen, const Vec3& wo);

  Float8 through(const Float8& cosine) const { return through_(cosine); }
  float through() const { return through_out_; }
  Vec3x8 eval(const Vec3x8& wi) const;

 private:
  Float8 lambda(const Float8& cosine) const;

  Vec3 wo_;
  Rgb scale_;                  // all that does not depend on wi
  float exponent_;             // of sin² of the half vector
  SheenMasking masking_;
  float lambda_out_, bound_out_, through_out_;
  CosineNodes through_;
  std::optional<CosineNodes> bounds_;
};

}  // namespace photond
