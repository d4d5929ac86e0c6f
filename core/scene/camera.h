#pragma once

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

/// The ray through film position `film` in [0,1]², (0,0) at the top left, for a film of width/height `aspect`.
Ray camera_ray(const Camera& camera, const Vec2& film, float aspect);

/// Angle (perspective, radians) or width (orthographic, metres) of one pixel at the centre of the film.
float pixel_spread(const Camera& camera, int film_height);

}  // namespace photond
