#pragma once

#include "core/math/float8.h"
#include "core/trace/cosine_nodes.h"

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
/// 1 − E for eight cosines of a layer of one reflectance and roughness, which is taken from the same table once.
class LayerTransmission {
 public:
  LayerTransmission(float f0, float f90, float alpha);
  Float8 operator()(const Float8& cosine) const;

 private:
  float f0_, f90_;
  bool smooth_;
  CosineNodes nodes_;   // unless smooth
};

/// Its cosine-weighted mean over the hemisphere.
LayerAlbedo layer_albedo_average(float alpha);

}  // namespace photond
