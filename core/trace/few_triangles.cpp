// Woop et al. 2013: rays and triangles, watertight. Seen along a ray, each vertex has one place in the plane across it,
// and each edge passes the ray on one side; rounding is monotonic, so that at worst it passes through it.
// Compiled without contraction: a·b − c·d would not be 0 where both products round to the same.
#include "core/trace/few_triangles.h"

#include <algorithm>
#include <cassert>

#include "core/math/float8.h"
#include "core/trace/crossing_rays.h"

namespace photond {

namespace {

constexpr std::size_t kFewOfMesh = 16;
// Largest share of the lines through the scene that may cross what covers the others: with .26 rays in a pool, most of
// which meet the water, take a third longer.
constexpr float kRest = 0.2f;
constexpr std::size_t kFew = 40;   // measured: 24 gain less, 72 lose in rooms of many boxes

// Of all instances, those that are not among some.
std::vector<std::uint32_t> others_than(const std::vector<std::uint32_t>& some, std::size_t count) {
  std::vector<std::uint32_t> others;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (std::ranges::find(some, i) == some.end()) others.push_back(i);
  }
  return others;
}

// Eight rays, and two directions across each: the first without rounding, so that what is seen along a ray is where it is.
struct Rays8 {
  Vec3x8 origin, direction, s, t;

  Rays8(const RayLanes& rays, std::uint32_t first)
      : origin(load8(rays.origin, first)), direction(load8(rays.direction, first)) {
    const Vec3x8& d = direction;
    const Float8 zero{};
    const Mask8 wide = d.x * d.x > d.y * d.y;
    s = {wide ? -d.z : zero, wide ? zero : d.z, wide ? d.x : -d.y};
    t = cross(d, s) * (1 / dot(d, d));   // no longer than s, whose products must not overflow
  }
};

}  // namespace

// How eight rays pass the edges, and where they meet the planes.
struct FewTriangles::Passing {
  Float8 edges[3 * kFew], planes[kFew];

  Passing(const FewTriangles& few, const Rays8& rays) {
    Float8 x[3 * kFew], y[3 * kFew];
    for (std::size_t i = 0; i < few.vertices_.size(); ++i) {
      const Vec3x8 p = few.vertices_[i] - rays.origin;
      x[i] = dot(p, rays.s);
      y[i] = dot(p, rays.t);
    }
    for (std::size_t i = 0; i < few.edges_.size(); ++i) {
      const Edge e = few.edges_[i];
      edges[i] = x[e.from] * y[e.to] - y[e.from] * x[e.to];
    }
    for (std::size_t i = 0; i < few.planes_.size(); ++i) {
      const Plane& p = few.planes_[i];
      planes[i] = dot(p.normal, p.point - rays.origin) / dot(p.normal, rays.direction);
    }
  }
  [[gnu::always_inline]] Float8 side(const Side& s) const {
    return reinterpret_cast<Float8>(reinterpret_cast<Mask8>(edges[s.edge]) ^ static_cast<std::int32_t>(s.reversed));
  }
};

// They and a triangle.
struct FewTriangles::Meeting {
  Float8 a, b, c, t;   // weights of the vertices, of any sum
  Mask8 met;           // before t_max

  [[gnu::always_inline]] Meeting(const Passing& passing, const Triangle& triangle, const Float8& t_max)
      : a(passing.side(triangle.sides[0])),
        b(passing.side(triangle.sides[1])),
        c(passing.side(triangle.sides[2])),
        t(passing.planes[triangle.plane]) {
    // Both where it is seen edge-on.
    const Mask8 inside = (min8(min8(a, b), c) >= 0) ^ (max8(max8(a, b), c) <= 0);
    met = inside & (t > 0) & (t < t_max);
  }
};

std::vector<std::uint32_t> FewTriangles::choose(const Scene& scene) {
  std::vector<std::uint32_t> few;
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const Mesh& mesh = scene.meshes[instance.mesh];
    const bool opaque = scene.materials[mesh.material].alpha_mode == AlphaMode::opaque;
    if (!instance.moved && opaque && mesh.triangles.size() <= kFewOfMesh) few.push_back(i);
  }
  const std::vector<Bounds3> bounds = instance_bounds(scene);
  std::ranges::stable_sort(few, std::greater(), [&](std::uint32_t i) { return bounds[i].radius(); });
  std::size_t sum = 0;
  std::erase_if(few, [&](std::uint32_t i) {
    const std::size_t count = scene.meshes[scene.instances[i].mesh].triangles.size();
    const bool fits = sum + count <= kFew;
    if (fits) sum += count;
    return !fits;
  });
  if (few.empty()) return few;
  const Cover others = cover(scene, others_than(few, scene.instances.size()));
  if (crossing_share(others, world_bounds(scene)) > kRest) few.clear();
  return few;
}

FewTriangles::FewTriangles(const Scene& scene, std::span<const std::uint32_t> instances) {
  for (const std::uint32_t instance : instances) {
    const std::size_t count = scene.meshes[scene.instances[instance].mesh].triangles.size();
    for (std::uint32_t i = 0; i < count; ++i) add(scene, instance, i);
  }
  assert(triangles_.size() <= kFew);   // else there is no room in Passing
}

void FewTriangles::add(const Scene& scene, std::uint32_t instance, std::uint32_t index) {
  const Mesh& mesh = scene.meshes[scene.instances[instance].mesh];
  const glm::uvec3& triangle = mesh.triangles[index];
  const Vec3 p[3] = {mesh.vertices[triangle.x].position, mesh.vertices[triangle.y].position,
                     mesh.vertices[triangle.z].position};
  const glm::dvec3 a(p[0]);
  const glm::dvec3 normal = glm::cross(glm::dvec3(p[1]) - a, glm::dvec3(p[2]) - a);
  const double length = glm::length(normal);
  if (!(length > 0)) return;   // no ray meets it
  const std::uint32_t v[3] = {vertex(p[0]), vertex(p[1]), vertex(p[2])};
  triangles_.push_back({{side(v[1], v[2]), side(v[2], v[0]), side(v[0], v[1])},
                        plane({p[0], Vec3(normal / length)}), instance, index});
}

std::uint32_t FewTriangles::vertex(const Vec3& position) {
  const auto at = std::ranges::find(vertices_, position);
  const auto index = static_cast<std::uint32_t>(at - vertices_.begin());
  if (at == vertices_.end()) vertices_.push_back(position);
  return index;
}

FewTriangles::Side FewTriangles::side(std::uint32_t from, std::uint32_t to) {
  constexpr std::uint32_t kSign = 0x80000000u;
  const Edge edge{std::min(from, to), std::max(from, to)};
  const auto at = std::ranges::find_if(edges_, [&](const Edge& e) { return e.from == edge.from && e.to == edge.to; });
  const auto index = static_cast<std::uint32_t>(at - edges_.begin());
  if (at == edges_.end()) edges_.push_back(edge);
  return {index, from > to ? kSign : 0};
}

// One for both triangles of a rectangle.
std::uint32_t FewTriangles::plane(const Plane& plane) {
  const auto at = std::ranges::find_if(planes_, [&](const Plane& p) {
    return p.normal == plane.normal && glm::dot(p.normal, p.point - plane.point) == 0;
  });
  const auto index = static_cast<std::uint32_t>(at - planes_.begin());
  if (at == planes_.end()) planes_.push_back(plane);
  return index;
}

void FewTriangles::intersect(const RayLanes& rays, std::uint32_t count, HitLanes& hits) const {
  for (std::uint32_t first = 0; first < count; first += 8) {
    const Passing passing(*this, Rays8(rays, first));
    Float8 t = load8(&rays.t_max[first]), b{}, c{}, sum = b + 1;
    Mask8 index{}, instance = index + static_cast<std::int32_t>(Hit::kNone);
    for (const Triangle& triangle : triangles_) {
      const Meeting m(passing, triangle, t);
      t = m.met ? m.t : t;
      b = m.met ? m.b : b;
      c = m.met ? m.c : c;
      sum = m.met ? m.a + m.b + m.c : sum;
      index = m.met ? Mask8{} + static_cast<std::int32_t>(triangle.index) : index;
      instance = m.met ? Mask8{} + static_cast<std::int32_t>(triangle.instance) : instance;
    }
    store8(&hits.t[first], t);
    store8(&hits.u[first], b / sum);
    store8(&hits.v[first], c / sum);
    store8(&hits.triangle[first], index);
    store8(&hits.instance[first], instance);
  }
}

void FewTriangles::occluded(const RayLanes& rays, std::uint32_t count, std::uint8_t (&hidden)[kLanes]) const {
  for (std::uint32_t first = 0; first < count; first += 8) {
    const Passing passing(*this, Rays8(rays, first));
    const Float8 t_max = load8(&rays.t_max[first]);
    Mask8 met{};
    for (const Triangle& triangle : triangles_) met |= Meeting(passing, triangle, t_max).met;
    const std::uint32_t bits = bits8(met);
    for (std::uint32_t k = 0; k < 8; ++k) hidden[first + k] = (bits >> k) & 1;
  }
}

}  // namespace photond
