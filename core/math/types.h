#pragma once

#include <algorithm>
#include <limits>
#include <numbers>

#include <glm/glm.hpp>

namespace photond {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Vec4 = glm::vec4;
using Rgb = glm::vec3;          ///< linear Rec. 709
using Affine = glm::mat4x3;     ///< column-major 3×4 matrix: linear part in columns 0–2, translation in column 3

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr float kInvPi = std::numbers::inv_pi_v<float>;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Relative luminance of linear Rec. 709.
inline float luminance(const Rgb& c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }
inline float max_component(const Vec3& v) { return std::max(v.x, std::max(v.y, v.z)); }
inline bool is_black(const Rgb& c) { return c.x == 0 && c.y == 0 && c.z == 0; }
inline bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

inline Vec3 transform_point(const Affine& m, const Vec3& p) { return m * Vec4(p, 1); }
inline Vec3 transform_vector(const Affine& m, const Vec3& v) { return m * Vec4(v, 0); }

/// Axis-aligned box; empty until a point is added.
struct Bounds3 {
  Vec3 min{kInfinity};
  Vec3 max{-kInfinity};

  bool empty() const { return !(min.x <= max.x); }
  void add(const Vec3& p) { min = glm::min(min, p); max = glm::max(max, p); }
  Vec3 center() const { return 0.5f * min + 0.5f * max; }
  Vec3 extent() const { return max - min; }
  /// Half the diagonal.
  float radius() const { return empty() ? 0.0f : 0.5f * glm::length(extent()); }
};

}  // namespace photond
