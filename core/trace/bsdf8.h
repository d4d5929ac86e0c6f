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
  Float8 to_base(const Vec3x8& wi, const Float8& cosine) const;

  // A GGX lobe about a normal.
  struct Reflection {
    Frame frame;
    Ggx facets;
    Vec3 wo;                   // local
    Rgb f0, f90;
    float lambda_out;

    Reflection(const Frame& about, const Ggx& of, const Vec3& out, const Rgb& at_normal, const Rgb& at_grazing);
    Float8 lambda(const Vec3x8& w) const;
    Vec3x8 times_cosine(const Vec3x8& wi) const;   // of incidence
  };
  // What lies over everything else.
  struct Coat {
    Vec3 normal;
    LayerTransmission through;
    float through_out;
  };

  Frame frame_;
  Vec3 ng_;
  Rgb diffuse_{0};             // f of the base, but for what the layers take of wi
  std::optional<LayerTransmission> layer_;
  std::optional<Reflection> reflection_, clearcoat_;
  std::optional<Coat> coat_;
  std::optional<Sheen8> sheen_;
  bool shines_ = false;        // by its sheen
};

}  // namespace photond
