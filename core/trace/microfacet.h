#pragma once

#include <cmath>

#include "core/math/types.h"

namespace photond {

/// Below this α a surface is a perfect mirror or smooth glass: the lobe is narrower than half floats resolve.
inline constexpr float kSmoothAlpha = 1e-4f;

/// The GGX distribution of microfacet normals with Smith masking, in the local frame of the macro normal (z).
/// Walter et al. 2007 (GGX, refraction), Heitz 2014 (height-correlated masking, anisotropy), Heitz 2018 (visible normals).
class Ggx {
 public:
  explicit Ggx(float alpha = 1) : x_(alpha), y_(alpha), product_(alpha * alpha) {}
  /// α along x and along y, neither 0.
  Ggx(float along_x, float along_y)
      : x_(along_x), y_(along_y), product_(along_x * along_y), ratio_(along_x / along_y), inverse_(along_y / along_x) {}

  bool isotropic() const { return x_ == y_; }
  /// The α where it is narrowest.
  float least() const { return std::min(x_, y_); }
  /// The α of an isotropic surface that looks about as rough from the unit vector `w`.
  float seen_from(const Vec3& w) const {
    if (isotropic()) return x_;
    const float x_sq = x_ * x_, y_sq = y_ * y_;
    return std::sqrt(x_sq * w.x * w.x + y_sq * w.y * w.y + 0.5f * (x_sq + y_sq) * w.z * w.z);
  }

  /// Density of microfacet normals per solid angle; ∫ D(h) cos h dh = 1.
  float d(const Vec3& h) const {
    if (h.z <= 0) return 0;
    // sin² + α² cos² keeps precision where α is small and h is near z, unlike cos²(α² − 1) + 1.
    const float t = (h.x * h.x * inverse_ + h.y * h.y * ratio_) + product_ * h.z * h.z;
    return product_ / (kPi * t * t);
  }

  /// Smith masking of one direction.
  float g1(const Vec3& w) const { return 1 / (1 + lambda(w)); }
  /// Height-correlated masking and shadowing of two directions.
  float g2(const Vec3& wo, const Vec3& wi) const { return 1 / (1 + lambda(wo) + lambda(wi)); }

  /// A normal distributed by the visible normals of `wo` (wo.z > 0) [Heitz 2018, listing 3].
  Vec3 sample_visible(const Vec3& wo, const Vec2& u) const {
    const Vec3 v = glm::normalize(Vec3(x_ * wo.x, y_ * wo.y, wo.z));
    const float length_sq = v.x * v.x + v.y * v.y;
    const Vec3 t1 = length_sq > 0 ? Vec3(-v.y, v.x, 0) / std::sqrt(length_sq) : Vec3(1, 0, 0);
    const Vec3 t2 = glm::cross(v, t1);
    const float r = std::sqrt(u.x);
    const float phi = 2 * kPi * u.y;
    const float p1 = r * std::cos(phi);
    const float s = 0.5f * (1 + v.z);
    const float p2 = (1 - s) * std::sqrt(std::max(0.0f, 1 - p1 * p1)) + s * r * std::sin(phi);
    const Vec3 n = p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0f, 1 - p1 * p1 - p2 * p2)) * v;
    return glm::normalize(Vec3(x_ * n.x, y_ * n.y, std::max(1e-7f, n.z)));
  }
  /// Its density per solid angle of h.
  float visible_pdf(const Vec3& wo, const Vec3& h) const {
    return g1(wo) * std::max(0.0f, glm::dot(wo, h)) * d(h) / wo.z;
  }

 private:
  friend class Bsdf8;

  float lambda(const Vec3& w) const {
    const float tan_sq = (w.x * w.x * ratio_ + w.y * w.y * inverse_) / std::max(w.z * w.z, 1e-20f);
    return 0.5f * (std::sqrt(1 + product_ * tan_sq) - 1);
  }

  float x_, y_;
  float product_;
  float ratio_ = 1, inverse_ = 1;   // of x to y
};

/// Unpolarized Fresnel reflectance of a dielectric boundary; `eta` is the index beyond it over the index on the
/// side of the ray, `cos_i` > 0. Sets `cos_t` > 0, or 0 under total internal reflection (where F = 1).
inline float fresnel_dielectric(float cos_i, float eta, float& cos_t) {
  cos_t = std::sqrt(std::max(1 - (1 - cos_i * cos_i) / (eta * eta), 0.0f));
  const float parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const float perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

/// (1 − cos)^5 of Schlick's approximation.
inline float schlick_weight(float cos_i) {
  const float m = std::clamp(1 - cos_i, 0.0f, 1.0f);
  const float m_sq = m * m;
  return m_sq * m_sq * m;
}

}  // namespace photond
