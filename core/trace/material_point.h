#pragma once

#include "core/trace/surface.h"

namespace photond {

/// A material at one point, textures and vertex colours applied. What else it has does not change from place to place.
struct MaterialPoint {
  Rgb base_color;
  float metallic;
  float roughness;           ///< perceptual
  float specular;
  Rgb specular_color;
  float transmission;
  float anisotropy;          ///< strength
  Vec2 anisotropy_direction; ///< of longest highlights, in tangent space, of any length
  float clearcoat;           ///< amount of the layer on top
  float clearcoat_roughness; ///< perceptual
  Rgb sheen_color;
  float sheen_roughness;     ///< perceptual
};

/// All of it at a point of a surface.
MaterialPoint material_at(const Scene& scene, const SurfacePoint& surface);
/// Its base colour alone.
Rgb base_color_at(const Scene& scene, const SurfacePoint& surface);

}  // namespace photond
