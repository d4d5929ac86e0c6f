#pragma once

#include "core/math/float8.h"
#include "core/trace/cosine_nodes.h"
#include "core/trace/microfacet.h"

namespace photond {

/// How much a GGX reflection layer of Schlick reflectance takes from what lies below it: the layer's directional
/// albedo is E(cos) = f0·a + f90·b, and `average` terms are its cosine-weighted means 2∫E cos d cos.
struct LayerAlbedo {
  float a = 0;
  float b = 0;
};

/// Directional albedo of the layer for the cosine of the viewing direction and GGX α; closed form where the layer
/// is smooth, otherwise from a table by bilinear interpolation (the furnace test bounds its error).
LayerAlbedo layer_albedo(float cos_o, float alpha);
/// Its cosine-weighted mean over the hemisphere.
LayerAlbedo layer_albedo_average(float alpha);

/// A layer of one reflectance and roughness. That of a brushed one is taken as isotropic, as rough as it looks.
struct Layer {
  float f0 = 0, f90 = 0;
  Ggx facets;

  bool reflects() const { return f0 > 0 || f90 > 0; }
  /// 1 − E for the unit vector `w`, local.
  float through(const Vec3& w) const;
};

/// The same for eight directions. What does not depend on them is taken from the table once.
class LayerTransmission {
 public:
  explicit LayerTransmission(const Layer& layer);

  /// Whether cosines say enough.
  bool isotropic() const { return layer_.facets.isotropic(); }
  Float8 operator()(const Float8& cosine) const;
  Float8 operator()(const Vec3x8& w) const;

 private:
  Layer layer_;
  bool smooth_;
  CosineNodes nodes_;   // unless smooth or brushed
};

}  // namespace photond
