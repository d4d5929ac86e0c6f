#include "core/photon/edges.h"

#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

#include "core/photon/morton_grid.h"

namespace photond {

namespace {

// Beyond this angle between their normals photons of one face do not count for the other.
constexpr float kSharpCos = 0.5f;

using Key = std::tuple<float, float, float>;
Key key(const Vec3& p) { return {p.x, p.y, p.z}; }

// One side of a triangle, with the triangle's normal; its ends in ascending order.
struct Side {
  Vec3 a, b;
  Vec3 normal;
};

void add_sides(const Scene& scene, const Instance& placed, std::vector<Side>& sides) {
  const Mesh& mesh = scene.meshes[placed.mesh];
  for (const glm::uvec3& t : mesh.triangles) {
    const Vec3 p[3] = {transform_point(placed.to_world, mesh.positions[t.x]),
                       transform_point(placed.to_world, mesh.positions[t.y]),
                       transform_point(placed.to_world, mesh.positions[t.z])};
    // In double, as squares of the largest areas and of the smallest are no floats.
    const glm::dvec3 normal = glm::cross(glm::dvec3(p[1] - p[0]), glm::dvec3(p[2] - p[0]));
    const double length = glm::length(normal);
    if (!(length > 0)) continue;
    for (int k = 0; k < 3; ++k) {
      Vec3 a = p[k], b = p[(k + 1) % 3];
      if (key(b) < key(a)) std::swap(a, b);
      sides.push_back({a, b, Vec3(normal / length)});
    }
  }
}

// Vertices that coincide are one vertex, whatever their indices. Two flat neighbours hide their side; one, or two at
// an angle, or more make an edge.
void collect(std::vector<Side>& sides, std::vector<Edges::Segment>& segments) {
  const auto ends = [](const Side& s) { return std::pair(key(s.a), key(s.b)); };
  std::sort(sides.begin(), sides.end(), [&](const Side& s, const Side& t) { return ends(s) < ends(t); });
  for (std::size_t i = 0, j = 0; i < sides.size(); i = j) {
    while (j < sides.size() && ends(sides[j]) == ends(sides[i])) ++j;
    const bool smooth = j - i == 2 && glm::dot(sides[i].normal, sides[i + 1].normal) > kSharpCos;
    if (!smooth) segments.push_back({sides[i].a, sides[i].b});
  }
}

Bounds3 bounds_of(const Edges::Segment& segment) {
  Bounds3 bounds;
  bounds.add(segment.a);
  bounds.add(segment.b);
  return bounds;
}

// Along a Morton curve, so that neighbours in the tree are neighbours in space.
void sort_by_place(std::vector<Edges::Segment>& segments) {
  Bounds3 bounds;
  for (const Edges::Segment& segment : segments) bounds.add(bounds_of(segment).center());
  const MortonGrid grid(bounds);
  std::ranges::stable_sort(segments, {}, [&](const Edges::Segment& s) { return grid.code(bounds_of(s).center()); });
}

}  // namespace

Edges::Edges(const Scene& scene) {
  std::vector<Side> sides;
  std::vector<Segment> segments;
  for (const Instance& placed : scene.instances) {
    // Photons pass through glass: its edges end nothing.
    if (scene.materials[scene.meshes[placed.mesh].material].transmission > 0) continue;
    sides.clear();
    add_sides(scene, placed, sides);
    collect(sides, segments);
  }
  sort_by_place(segments);
  size_ = static_cast<std::uint32_t>(segments.size());
  segments_ = make_large_array<Segment>(size_);
  std::ranges::copy(segments, segments_.get());
  tree_ = BoxTree(size_);
  for (std::uint32_t i = 0; i < size_; ++i) tree_.set(i, bounds_of(segments_[i]));
  tree_.close({});
}

std::optional<Edges> Edges::over(std::span<const Segment> segments, std::span<const std::byte> tree_nodes,
                                 std::shared_ptr<const void> owner) {
  Edges edges;
  edges.size_ = static_cast<std::uint32_t>(segments.size());
  auto tree = BoxTree::over(edges.size_, tree_nodes, owner);
  if (!tree) return std::nullopt;
  edges.segments_ = view_large_array(segments, std::move(owner));
  edges.tree_ = std::move(*tree);
  return edges;
}

}  // namespace photond
