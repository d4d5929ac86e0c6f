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

Ray camera_ray(const Camera& camera, const Vec2& film, float aspect) {
  const Vec2 ndc{(2 * film.x - 1) * aspect, 1 - 2 * film.y};
  if (camera.orthographic) {
    const Vec3 origin{ndc * camera.ymag, 0};
    return {transform_point(camera.to_world, origin), -camera.to_world[2]};
  }
  const Vec3 direction{ndc * std::tan(0.5f * camera.yfov), -1};
  return {camera.to_world[3], glm::normalize(transform_vector(camera.to_world, direction))};
}

float pixel_spread(const Camera& camera, int film_height) {
  const float height = static_cast<float>(film_height);
  if (camera.orthographic) return 2 * camera.ymag / height;
  return 2 * std::tan(0.5f * camera.yfov) / height;
}

}  // namespace photond
