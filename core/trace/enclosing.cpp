#include "core/trace/enclosing.h"

#include <algorithm>
#include <vector>

#include "core/trace/surface.h"

namespace photond {

bool has_followed_volumes(const Scene& scene) {
  return std::any_of(scene.instances.begin(), scene.instances.end(), [&](const Instance& instance) {
    return Medium::follows(scene.materials[scene.meshes[instance.mesh].material]);
  });
}

Medium enclosing(const Scene& scene, const Accel& accel, const Vec3& point) {
  Medium medium;
  constexpr int kMostFaces = 256;
  Ray ray{point, glm::normalize(Vec3(0.36f, 0.79f, 0.51f))};   // along no axis: edges are where models are symmetric
  std::vector<const Material*> crossed, around;   // entered since the start; left without, from the innermost on
  for (int face = 0; face < kMostFaces; ++face) {
    const Hit hit = accel.intersect(ray);
    if (!hit.found()) break;
    const SurfacePoint surface = make_surface(scene, ray, hit);
    ray = spawn_ray(surface, ray.direction);
    if (surface.material->transmission == 0 || surface.material->thin_walled) continue;
    const auto entered = std::find(crossed.begin(), crossed.end(), surface.material);
    if (surface.front) {
      crossed.push_back(surface.material);
    } else if (entered != crossed.end()) {
      crossed.erase(entered);
    } else {
      around.push_back(surface.material);
    }
  }
  for (auto outer = around.rbegin(); outer != around.rend(); ++outer) medium.enter(scene, **outer);
  return medium;
}

}  // namespace photond
