#include "core/scene/camera.h"

#include <cmath>

namespace photond {

Camera look_at(const Vec3& eye, const Vec3& target, const Vec3& up, float yfov) {
  const Vec3 backward = glm::normalize(eye - target);
  const Vec3 right = glm::normalize(glm::cross(up, backward));
  Camera camera;
  camera.to_world = Affine(right, glm::cross(backward, right), backward, eye);
  camera.yfov = yfov;
  return camera;
}

View::View(const Camera& camera, float aspect) : origin_(camera.to_world[3]), direction_(-camera.to_world[2]) {
  const float high = camera.orthographic ? camera.ymag : std::tan(0.5f * camera.yfov);
  const Vec3 right = high * aspect * camera.to_world[0];
  const Vec3 up = high * camera.to_world[1];
  Vec3& top_left = camera.orthographic ? origin_ : direction_;
  top_left += up - right;
  (camera.orthographic ? origin_x_ : direction_x_) = 2.0f * right;
  (camera.orthographic ? origin_y_ : direction_y_) = -2.0f * up;
}

Ray camera_ray(const Camera& camera, const Vec2& film, float aspect) { return View(camera, aspect).ray(film); }

float pixel_spread(const Camera& camera, int film_height) {
  const float height = static_cast<float>(film_height);
  if (camera.orthographic) return 2 * camera.ymag / height;
  return 2 * std::tan(0.5f * camera.yfov) / height;
}

}  // namespace photond
