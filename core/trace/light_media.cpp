#include "core/trace/light_media.h"

#include "core/trace/surface.h"

namespace photond {

namespace {

// Whether the border of a volume is met on the way.
bool crosses_border(const Scene& scene, const Accel& accel, const Vec3& from, const Vec3& to) {
  constexpr int kMostFaces = 64;
  Ray ray{from, to - from};   // t from 0 to 1
  for (int face = 0; face < kMostFaces; ++face) {
    const float length = glm::distance(ray.origin, to);
    if (!(length > 0)) return false;
    ray.direction = (to - ray.origin) / length;
    const Hit hit = accel.intersect(ray);
    if (!hit.found() || hit.t >= length) return false;
    const SurfacePoint surface = make_surface(scene, ray, hit);
    if (surface.material->transmission > 0 && !surface.material->thin_walled) return true;
    ray = spawn_ray(surface, ray.direction);
  }
  return false;
}

// Along the triangle's edges and from a corner to its middle, on its front.
bool is_divided(const Scene& scene, const Accel& accel, const EmitterTriangle& emitter) {
  const auto place = [&](float u, float v) {
    return spawn_point(emitter.at({u, v}), emitter.normal, emitter.extent, emitter.normal);
  };
  const Vec3 corners[] = {place(0, 0), place(1, 0), place(0, 1)}, middle = place(1.0f / 3, 1.0f / 3);
  for (int i = 0; i < 3; ++i) {
    if (crosses_border(scene, accel, corners[i], corners[(i + 1) % 3])) return true;
  }
  return crosses_border(scene, accel, corners[0], middle);
}

}  // namespace

LightMedia find_light_media(const Scene& scene, const Accel& accel, const Lights& lights, const Execution& execution) {
  if (!has_followed_volumes(scene)) return {};
  LightMedia media{std::vector<Medium>(lights.size()), {}};
  std::vector<std::uint8_t> divided(lights.size());   // of bytes: threads write side by side
  parallel_for(execution, media.around.size(), 64, [&](std::size_t i) {
    const std::optional<Vec3> place = lights.place(scene, static_cast<std::uint32_t>(i));
    if (place) media.around[i] = enclosing(scene, accel, *place);
    if (i < lights.emitters().size()) divided[i] = is_divided(scene, accel, lights.emitters()[i]);
  });
  media.divided.assign(divided.begin(), divided.end());
  return media;
}

}  // namespace photond
