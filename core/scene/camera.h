#pragma once

#include <cmath>
#include <string>

#include "core/math/types.h"

namespace photond {

/// A ray with unit direction and parameter range (0, t_max).
struct Ray {
  Vec3 origin{0};
  Vec3 direction{0, 0, 1};
  float t_max = kInfinity;
};

/// A glTF camera in the world: looks along −z of `to_world`, y up. The linear part is orthonormal.
struct Camera {
  std::string name;
  Affine to_world{1};
  bool orthographic = false;
  float yfov = 0.7f;               ///< full vertical angle, radians (perspective)
  float ymag = 1;                  ///< half height of the view, metres (orthographic)
};

/// A camera at `eye` looking at `target`. `up` must not be parallel to the view.
Camera look_at(const Vec3& eye, const Vec3& target, const Vec3& up, float yfov);

/// The view of a camera through a film of width/height `aspect`: origin and direction of its rays are linear in the place
/// on the film.
class View {
 public:
  View(const Camera& camera, float aspect);

  /// The ray through film position `film` in [0,1]², (0,0) at the top left.
  [[gnu::always_inline]] Ray ray(const Vec2& film) const {
    const Vec3 along = direction_ + film.x * direction_x_ + film.y * direction_y_;
    return {origin_ + film.x * origin_x_ + film.y * origin_y_, along * (1 / std::sqrt(glm::dot(along, along)))};
  }

 private:
  Vec3 origin_, origin_x_{0}, origin_y_{0};
  Vec3 direction_, direction_x_{0}, direction_y_{0};
};

/// One such ray.
Ray camera_ray(const Camera& camera, const Vec2& film, float aspect);

/// Angle (perspective, radians) or width (orthographic, metres) of one pixel at the centre of the film.
float pixel_spread(const Camera& camera, int film_height);

}  // namespace photond
