#include "core/trace/nested.h"

#include <vector>

#include "core/base/features.h"

namespace photond {

namespace {

// All pairs of so many boxes are looked at in 10 ms.
constexpr std::size_t kMany = 2048;

struct Volume {
  Bounds3 box;
  Material* material;
  bool cavity;           // its front is on the inside
};

bool is_cavity(const Mesh& mesh) {
  Bounds3 box;
  for (const Vec3& p : mesh.positions) box.add(p);
  const glm::dvec3 center(box.center());
  double volume = 0;     // six times it
  for (const glm::uvec3& t : mesh.triangles) {
    const auto from_center = [&](std::uint32_t i) { return glm::dvec3(mesh.positions[i]) - center; };
    volume += glm::dot(from_center(t.x), glm::cross(from_center(t.y), from_center(t.z)));
  }
  return volume < 0;
}

bool overlap(const Bounds3& a, const Bounds3& b) {
  return glm::all(glm::lessThanEqual(a.min, b.max)) && glm::all(glm::lessThanEqual(b.min, a.max));
}

bool holds(const Bounds3& a, const Bounds3& b) {
  return glm::all(glm::lessThan(a.min, b.min)) && glm::all(glm::lessThan(b.max, a.max));
}

// The inner side of a shell encloses what is outside of both.
bool reach_into_one_another(const Volume& a, const Volume& b) {
  const bool shell = (b.cavity && holds(a.box, b.box)) || (a.cavity && holds(b.box, a.box));
  return !shell && overlap(a.box, b.box);
}

std::vector<Volume> volumes(Scene& scene) {
  std::vector<Volume> found;
  const std::vector<Bounds3> boxes = instance_bounds(scene);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    Material& material = scene.materials[mesh.material];
    if (material.transmission > 0 && !material.thin_walled) found.push_back({boxes[i], &material, is_cavity(mesh)});
  }
  return found;
}

}  // namespace

void find_nested(Scene& scene) {
  if (!kAllFeatures) return;
  const std::vector<Volume> all = volumes(scene);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < i && all.size() <= kMany; ++j) {
      if (reach_into_one_another(all[i], all[j])) all[i].material->nested = all[j].material->nested = true;
    }
    if (all.size() > kMany) all[i].material->nested = true;
  }
}

}  // namespace photond
