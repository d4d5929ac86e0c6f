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

/// The volumes (KHR_materials_volume) a path travels in, one within another, from the outermost that is followed on; the
/// innermost absorbs, and its index is that around what else is met. Followed through the path's refractions; at most
/// kMost of them.
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
    const Material& m = scene.materials[within_[count() - 1] - 1u];
    return absorbs(m) ? beer_lambert(m, distance) : Rgb(1);
  }

  /// The index of the material of a surface that the path meets over that of what lies on its front, as SurfacePoint::ior.
  /// Where volumes overlap, the one entered last displaces the others: their borders within it bend nothing.
  float relative_index(const Scene& scene, const SurfacePoint& surface) const {
    const Material& m = *surface.material;
    if (!active() || m.thin_walled || m.transmission == 0 || surface.ior == 0) return surface.ior;
    std::size_t around = count();
    if (!surface.front) {
      const std::size_t place = find(scene, m);
      if (place == kMost) return surface.ior;
      if (place + 1 < around) return 1;
      --around;
    }
    const float outer = around == 0 ? 1 : scene.materials[within_[around - 1] - 1u].ior;
    return outer == 0 ? surface.ior : surface.ior / outer;
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
    const std::size_t entered = number(scene, material), place = count();
    if ((!active() && !follows(material)) || entered > UINT16_MAX || place == kMost) return;
    within_[place] = static_cast<std::uint16_t>(entered);
  }

  bool active() const { return kAllFeatures && within_[0] != 0; }

  static bool absorbs(const Material& m) {
    return kAllFeatures && m.transmission > 0 && !m.thin_walled && m.attenuation_distance < kInfinity;
  }
  /// Whether a path must know that it is within.
  static bool follows(const Material& m) { return absorbs(m) || (kAllFeatures && m.nested); }

 private:
  static std::size_t number(const Scene& scene, const Material& material) {
    return static_cast<std::size_t>(&material - scene.materials.data()) + 1;
  }
  std::size_t count() const {
    std::size_t n = 0;
    while (n < kMost && within_[n] != 0) ++n;
    return n;
  }
  // The innermost of that material or, where there is none, of its index: the two sides of a shell may have materials of
  // their own. kMost where there is none.
  std::size_t find(const Scene& scene, const Material& material) const {
    std::size_t alike = kMost;
    for (std::size_t i = count(); i-- > 0;) {
      if (within_[i] == number(scene, material)) return i;
      if (alike == kMost && scene.materials[within_[i] - 1u].ior == material.ior) alike = i;
    }
    return alike;
  }

  // What is left within nothing that is followed is as good as nowhere.
  void leave(const Scene& scene, const Material& material) {
    std::size_t i = find(scene, material);
    if (i == kMost) return;
    for (; i + 1 < kMost; ++i) within_[i] = within_[i + 1];
    within_[kMost - 1] = 0;
    while (active() && !follows(scene.materials[within_[0] - 1u])) leave(scene, scene.materials[within_[0] - 1u]);
  }

  static Rgb beer_lambert(const Material& m, float distance) {
    return glm::pow(m.attenuation_color, Rgb(distance / m.attenuation_distance));
  }

  std::array<std::uint16_t, kMost> within_{};   // materials by number, counted from one; 0: no more
};

}  // namespace photond
