#pragma once

#include <cmath>

#include "core/trace/bsdf.h"

namespace photond {

/// The squared index beyond a transmitting surface over that on the side a path comes from, which is its front or not;
/// 1 of thin walls. Refraction divides the radiance a path from the eye sees, and the étendue of a path from a light,
/// by it.
inline float compression(const Material& material, bool front) {
  if (material.thin_walled || material.ior == 0) return 1;
  const float eta_sq = material.ior * material.ior;
  return front ? eta_sq : 1 / eta_sq;
}

/// The absorbing volume (KHR_materials_volume) a path travels in, followed through its refractions.
class Medium {
 public:
  /// Fraction of light that survives `distance` metres up to `surface`. A path that started inside a volume is
  /// noticed where it meets the volume's back face.
  Rgb transmittance(const SurfacePoint& surface, float distance) const {
    const Material* m = material_;
    if (m == nullptr && !surface.front && absorbs(*surface.material)) m = surface.material;
    return m == nullptr ? Rgb(1) : beer_lambert(*m, distance);
  }
  /// The same for a segment that ends elsewhere than on a surface.
  Rgb transmittance(float distance) const { return active() ? beer_lambert(*material_, distance) : Rgb(1); }

  /// Follows a scattering event: refraction at a front face enters the volume, at a back face leaves it.
  void cross(const SurfacePoint& surface, const BsdfSample& sample) {
    if (!sample.transmitted || surface.material->thin_walled) return;
    material_ = surface.front && absorbs(*surface.material) ? surface.material : nullptr;
  }

  bool active() const { return kAllFeatures && material_ != nullptr; }

  static bool absorbs(const Material& m) {
    return kAllFeatures && !m.thin_walled && m.attenuation_distance < kInfinity;
  }

 private:
  static Rgb beer_lambert(const Material& m, float distance) {
    return glm::pow(m.attenuation_color, Rgb(distance / m.attenuation_distance));
  }

  const Material* material_ = nullptr;
};

}  // namespace photond
