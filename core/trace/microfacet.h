#pragma once

#include <cmath>

#include "core/math/types.h"

namespace photond {

// The GGX distribution of microfacet normals with Smith masking, in the local frame of the macro normal (z).
// Walter et al. 2007 (GGX, refraction), Heitz 2014 (height-correlated masking), Heitz 2018 (visible normals).

/// Below this α a surface is a perfect mirror or smooth glass: the lobe is narrower than half floats resolve.
inline constexpr float kSmoothAlpha = 1e-4f;

/// Density of microfacet normals per solid angle; ∫ D(h) cos h dh = 1.
inline float ggx_d(const Vec3& h, float alpha) {
  if (h.z <= 0) return 0;
  const float a_sq = alpha * alpha;
  // sin² + α² cos² keeps precision where α is small and h is near z, unlike cos²(α² − 1) + 1.
  const float sin_sq = h.x * h.x + h.y * h.y;
  const float t = sin_sq + a_sq * h.z * h.z;
  return a_sq / (kPi * t * t);
}

inline float ggx_lambda(const Vec3& w, float alpha) {
  const float cos_sq = w.z * w.z;
  const float tan_sq = (w.x * w.x + w.y * w.y) / std::max(cos_sq, 1e-20f);
  return 0.5f * (std::sqrt(1 + alpha * alpha * tan_sq) - 1);
}

/// Smith masking of one direction.
inline float ggx_g1(const Vec3& w, float alpha) { return 1 / (1 + ggx_lambda(w, alpha)); }

/// Height-correlated masking and shadowing of two directions.
inline float ggx_g2(const Vec3& wo, const Vec3& wi, float alpha) {
  return 1 / (1 + ggx_lambda(wo, alpha) + ggx_lambda(wi, alpha));
}

/// A normal distributed by the visible normals of `wo` (wo.z > 0) [Heitz 2018, listing 3].
inline Vec3 ggx_sample_visible(const Vec3& wo, float alpha, const Vec2& u) {
  const Vec3 v = glm::normalize(Vec3(alpha * wo.x, alpha * wo.y, wo.z));
  const float length_sq = v.x * v.x + v.y * v.y;
  const Vec3 t1 = length_sq > 0 ? Vec3(-v.y, v.x, 0) / std::sqrt(length_sq) : Vec3(1, 0, 0);
  const Vec3 t2 = glm::cross(v, t1);
  const float r = std::sqrt(u.x);
  const float phi = 2 * kPi * u.y;
  const float p1 = r * std::cos(phi);
  const float s = 0.5f * (1 + v.z);
  const float p2 = (1 - s) * std::sqrt(std::max(0.0f, 1 - p1 * p1)) + s * r * std::sin(phi);
  const Vec3 n = p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0f, 1 - p1 * p1 - p2 * p2)) * v;
  return glm::normalize(Vec3(alpha * n.x, alpha * n.y, std::max(1e-7f, n.z)));
}
/// Its density per solid angle of h.
inline float ggx_visible_pdf(const Vec3& wo, const Vec3& h, float alpha) {
  return ggx_g1(wo, alpha) * std::max(0.0f, glm::dot(wo, h)) * ggx_d(h, alpha) / wo.z;
}

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
