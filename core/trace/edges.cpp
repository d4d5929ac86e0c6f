#include "core/trace/edges.h"

#include <algorithm>
#include <cstring>
#include <tuple>

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
    const Vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
    const float length = glm::length(normal);
    if (!(length > 0)) continue;
    for (int k = 0; k < 3; ++k) {
      Vec3 a = p[k], b = p[(k + 1) % 3];
      if (key(b) < key(a)) std::swap(a, b);
      sides.push_back({a, b, normal / length});
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

}  // namespace

Edges::Edges(const Scene& scene) {
  std::vector<Side> sides;
  for (const Instance& placed : scene.instances) {
    // Photons pass through glass: its edges end nothing.
    if (scene.materials[scene.meshes[placed.mesh].material].transmission > 0) continue;
    sides.clear();
    add_sides(scene, placed, sides);
    collect(sides, segments_);
  }
  if (!segments_.empty()) build(0, static_cast<std::uint32_t>(segments_.size()));
}

std::optional<Edges> Edges::of(std::span<const Segment> segments, std::span<const std::byte> nodes) {
  if (nodes.size() % sizeof(Node) != 0 || nodes.empty() != segments.empty()) return std::nullopt;
  Edges edges;
  edges.segments_.assign(segments.begin(), segments.end());
  edges.nodes_.resize(nodes.size() / sizeof(Node));
  if (!nodes.empty()) std::memcpy(edges.nodes_.data(), nodes.data(), nodes.size());
  return edges;
}

std::uint32_t Edges::build(std::uint32_t begin, std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({{}, begin, end, 0});
  Bounds3 bounds;
  for (std::uint32_t i = begin; i < end; ++i) {
    bounds.add(segments_[i].a);
    bounds.add(segments_[i].b);
  }
  nodes_[index].bounds = bounds;
  if (end - begin <= kLeafSize) return index;
  const Vec3 extent = bounds.extent();
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(segments_.begin() + begin, segments_.begin() + middle, segments_.begin() + end,
                   [axis](const Segment& s, const Segment& t) { return s.a[axis] + s.b[axis] < t.a[axis] + t.b[axis]; });
  build(begin, middle);
  const std::uint32_t right = build(middle, end);
  nodes_[index].right = right;
  return index;
}

}  // namespace photond
