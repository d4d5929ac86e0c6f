#include "core/trace/surface_boxes.h"

#include <algorithm>
#include <span>

#include "core/math/transform.h"

namespace photond {

namespace {

constexpr int kSide = 32;   // cells along the longest axis
// From so many triangles on whole instances are held, and no triangles are halved after so many: corners take memory.
constexpr std::size_t kMost = std::size_t{1} << 20;

struct Piece {
  Vec3 a, b, c;
};

Bounds3 bounds_of(std::span<const Vec3> points) {
  Bounds3 box;
  for (const Vec3& p : points) box.add(p);
  return box;
}

// Collects small pieces by the cells where the middles of their boxes lie.
class Grid {
 public:
  explicit Grid(const Bounds3& bounds)
      : origin_(bounds.min), cell_(max_component(bounds.extent()) / kSide), boxes_(kSide * kSide * kSide) {}

  // In small parts.
  void add(const Piece& piece) {
    const Vec3 points[] = {piece.a, piece.b, piece.c};
    const bool small = !(max_component(bounds_of(points).extent()) > 0.5f * cell_);
    if (small || !halve(piece)) hold(points);
  }
  // As a whole.
  void hold(std::span<const Vec3> points) {
    const Bounds3 box = bounds_of(points);
    if (box.empty()) return;
    SurfaceBox& cell = boxes_[index(box.center())];
    cell.bounds.add(box.min);
    cell.bounds.add(box.max);
    cell.corners.insert(cell.corners.end(), points.begin(), points.end());
  }

  std::vector<SurfaceBox> boxes() && {
    std::erase_if(boxes_, [](const SurfaceBox& box) { return box.corners.empty(); });
    return std::move(boxes_);
  }

 private:
  // Adds the two halves on either side of the middle of the longest edge. False where there is no middle.
  bool halve(const Piece& p) {
    const float ab = glm::distance(p.a, p.b), bc = glm::distance(p.b, p.c), ca = glm::distance(p.c, p.a);
    if (bc >= ab && bc >= ca) return halve(p.b, p.c, p.a);
    return ab >= ca ? halve(p.a, p.b, p.c) : halve(p.c, p.a, p.b);
  }
  bool halve(const Vec3& from, const Vec3& to, const Vec3& opposite) {
    const Vec3 middle = 0.5f * from + 0.5f * to;
    if (halved_ == kMost || middle == from || middle == to) return false;
    ++halved_;
    add({from, middle, opposite});
    add({middle, to, opposite});
    return true;
  }

  std::size_t index(const Vec3& p) const {
    const auto along = [&](int axis) {
      const float cells = cell_ > 0 ? (p[axis] - origin_[axis]) / cell_ : 0;
      return static_cast<std::size_t>(std::clamp(cells, 0.0f, static_cast<float>(kSide - 1)));
    };
    return (along(2) * kSide + along(1)) * kSide + along(0);
  }

  Vec3 origin_;
  float cell_;
  std::vector<SurfaceBox> boxes_;
  std::size_t halved_ = 0;
};

std::size_t placed_triangles(const Scene& scene) {
  std::size_t count = 0;
  for (const Instance& instance : scene.instances) count += scene.meshes[instance.mesh].triangles.size();
  return count;
}

}  // namespace

std::vector<SurfaceBox> surface_boxes(const Scene& scene, const Bounds3& bounds) {
  if (bounds.empty()) return {};
  Grid grid(bounds);
  if (placed_triangles(scene) > kMost) {
    for (const Bounds3& box : instance_bounds(scene)) {
      Vec3 corners[8];
      for (std::uint32_t i = 0; i < 8; ++i) {
        corners[i] = {(i & 1 ? box.max : box.min).x, (i & 2 ? box.max : box.min).y, (i & 4 ? box.max : box.min).z};
      }
      grid.hold(corners);
    }
    return std::move(grid).boxes();
  }
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    const auto corner = [&](std::uint32_t vertex) {
      return transform_point(instance.to_world, mesh.positions[vertex]);
    };
    for (const glm::uvec3& t : mesh.triangles) grid.add({corner(t.x), corner(t.y), corner(t.z)});
  }
  return std::move(grid).boxes();
}

}  // namespace photond
