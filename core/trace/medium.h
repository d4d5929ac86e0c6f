#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "core/trace/bsdf.h"

namespace photond {

/// The squared index beyond a transmitting surface over that on the side a path comes from, which is its front or not;
/// 1 of thin walls. Refraction divides the radiance a path from the eye sees, and the étendue of a path from a light,
/// by it.
inline float compression(const SurfacePoint& surface) {
  if (surface.material->thin_walled || surface.ior == 0) return 1;
  const float eta_sq = surface.ior * surface.ior;
  return surface.front ? eta_sq : 1 / eta_sq;
}

/// The volumes (KHR_materials_volume) a path travels in, one within another, from the outermost that absorbs on; the
/// innermost absorbs. Followed through the path's refractions; at most kMost of them.
class Medium {
 public:
  static constexpr std::size_t kMost = 4;

  /// Fraction of light that survives `distance` metres up to `surface`. A path of which it was not known that it started
  /// inside a volume is noticed where it meets the volume's back face.
  Rgb transmittance(const Scene& scene, const SurfacePoint& surface, float distance) const {
    if (active()) return transmittance(scene, distance);
    return !surface.front && absorbs(*surface.material) ? beer_lambert(*surface.material, distance) : Rgb(1);
  }
  /// The same for a segment that ends elsewhere than on a surface.
  Rgb transmittance(const Scene& scene, float distance) const {
    if (!active()) return Rgb(1);
    std::size_t innermost = 0;
    while (innermost + 1 < kMost && within_[innermost + 1] != 0) ++innermost;
    const Material& m = scene.materials[within_[innermost] - 1u];
    return absorbs(m) ? beer_lambert(m, distance) : Rgb(1);
  }

  /// Follows a scattering event: refraction at a front face enters the volume, at a back face leaves it, and what is
  /// reflected at a back face is within.
  void cross(const Scene& scene, const SurfacePoint& surface, bool transmitted) {
    if (surface.material->thin_walled || (surface.material->transmission == 0)) return;
    if (transmitted && !surface.front) return leave(scene, *surface.material);
    const bool noticed = !transmitted && !surface.front && !active();
    if (transmitted || noticed) enter(scene, *surface.material);
  }

  /// Goes into one more volume, of a material of the scene.
  void enter(const Scene& scene, const Material& material) {
    const auto number = static_cast<std::size_t>(&material - scene.materials.data()) + 1;
    if ((!active() && !absorbs(material)) || number > UINT16_MAX) return;
    for (std::uint16_t& place : within_) {
      if (place != 0) continue;
      place = static_cast<std::uint16_t>(number);
      return;
    }
  }

  bool active() const { return kAllFeatures && within_[0] != 0; }

  static bool absorbs(const Material& m) {
    return kAllFeatures && m.transmission > 0 && !m.thin_walled && m.attenuation_distance < kInfinity;
  }

 private:
  // The innermost of that material. What is left within nothing that absorbs is as good as nowhere.
  void leave(const Scene& scene, const Material& material) {
    const auto number = static_cast<std::size_t>(&material - scene.materials.data()) + 1;
    std::size_t i = kMost;
    while (i > 0 && within_[i - 1] != number) --i;
    if (i == 0) return;
    for (; i < kMost; ++i) within_[i - 1] = within_[i];
    within_[kMost - 1] = 0;
    while (active() && !absorbs(scene.materials[within_[0] - 1u])) leave(scene, scene.materials[within_[0] - 1u]);
  }

  static Rgb beer_lambert(const Material& m, float distance) {
    return glm::pow(m.attenuation_color, Rgb(distance / m.attenuation_distance));
  }

  std::array<std::uint16_t, kMost> within_{};   // materials by number, counted from one; 0: no more
};

}  // namespace photond
