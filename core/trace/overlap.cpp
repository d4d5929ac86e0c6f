#include "core/trace/overlap.h"

namespace photond {

namespace {

// All pairs of so many boxes are looked at in 10 ms.
constexpr std::size_t kMany = 2048;
// To meet the triangles of two such meshes costs no more than to find out which comes first.
constexpr std::size_t kFewTriangles = 16;

Bounds3 common(const Bounds3& a, const Bounds3& b) { return {glm::max(a.min, b.min), glm::min(a.max, b.max)}; }

bool is_empty(const Bounds3& box) { return glm::any(glm::lessThan(box.max, box.min)); }

}  // namespace

float half_surface(const Bounds3& box) {
  if (box.empty()) return 0;
  const Vec3 e = box.extent();
  return e.x * e.y + e.y * e.z + e.z * e.x;
}

float overlap(const Scene& scene) {
  const float whole = half_surface(world_bounds(scene));
  if (!(whole > 0)) return 0;
  const std::vector<Bounds3> all = instance_bounds(scene);
  std::vector<Bounds3> boxes;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (scene.meshes[scene.instances[i].mesh].triangles.size() > kFewTriangles) boxes.push_back(all[i]);
  }
  if (boxes.size() > kMany) return kInfinity;
  float sum = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Bounds3 both = common(boxes[i], boxes[j]);
      if (!is_empty(both)) sum += half_surface(both) / whole;
    }
  }
  return sum;
}

}  // namespace photond
