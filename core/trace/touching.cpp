#include "core/trace/touching.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <span>
#include <vector>

#include "core/math/transform.h"

namespace photond {

namespace {

constexpr float kUlp = 0x1p-23f;          // of the largest coordinate
constexpr float kCoincide = 24 * kUlp;    // closer than that, the ray that goes on may begin beyond both (spawn_point)
constexpr float kApart = 64 * kUlp;

// A triangle in the world.
struct Placed {
  std::array<Vec3, 3> corners;
  Vec3 normal;              // unit, of the front
  float extent = 0;         // largest |coordinate| of the corners
  Bounds3 box;              // not smaller than what coincides with the triangle may touch
  std::uint32_t triangle = 0;
};
using Triangles = std::vector<const Placed*>;

bool apart(const Bounds3& a, const Bounds3& b) {
  return glm::any(glm::greaterThan(a.min, b.max)) || glm::any(glm::greaterThan(b.min, a.max));
}

float largest_coordinate(const Bounds3& box) {
  return std::max(max_component(glm::abs(box.min)), max_component(glm::abs(box.max)));
}

Bounds3 widened(Bounds3 box) {
  const float by = kCoincide * largest_coordinate(box);
  return {box.min - by, box.max + by};
}

// Those of an instance that reach into a box; flat ones have no place in it.
std::vector<Placed> triangles_in(const Scene& scene, const Instance& instance, const Bounds3& box) {
  const Mesh& mesh = scene.meshes[instance.mesh];
  std::vector<Placed> found;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    Placed placed{.triangle = t};
    for (int i = 0; i < 3; ++i) {
      const Vec3 corner = transform_point(instance.to_world, mesh.positions[mesh.triangles[t][i]]);
      placed.corners[static_cast<std::size_t>(i)] = corner;
      placed.box.add(corner);
    }
    placed.extent = largest_coordinate(placed.box);
    placed.box = widened(placed.box);
    if (apart(placed.box, box)) continue;
    const auto& [a, b, c] = placed.corners;
    const Vec3 normal = is_mirrored(instance.to_world) ? glm::cross(c - a, b - a) : glm::cross(b - a, c - a);
    const float length = glm::length(normal);
    if (!(length > 0)) continue;
    placed.normal = normal / length;
    found.push_back(placed);
  }
  return found;
}

bool in_plane(const Placed& corners_of, const Placed& plane, float tolerance) {
  return std::ranges::all_of(corners_of.corners, [&](const Vec3& corner) {
    return std::abs(glm::dot(corner - plane.corners[0], plane.normal)) <= tolerance;
  });
}

// Whether a line along an edge of `t`, seen along the normal `n`, has `u` on its other side.
bool edge_separates(const Placed& t, const Placed& u, const Vec3& n, float tolerance) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 &from = t.corners[i], &to = t.corners[(i + 1) % 3], &opposite = t.corners[(i + 2) % 3];
    Vec3 across = glm::cross(n, to - from);
    const float length = glm::length(across);
    if (!(length > 0)) continue;
    across /= glm::dot(across, opposite - from) < 0 ? -length : length;
    const auto beyond = [&](const Vec3& corner) { return glm::dot(corner - from, across) <= tolerance; };
    if (std::ranges::all_of(u.corners, beyond)) return true;
  }
  return false;
}

// Whether they lie in one plane and have more than an edge in common.
bool coincide(const Placed& t, const Placed& u) {
  constexpr float kParallel = 0.99f;   // of slivers any plane contains the corners
  if (apart(t.box, u.box) || std::abs(glm::dot(t.normal, u.normal)) < kParallel) return false;
  const float tolerance = kCoincide * std::max(t.extent, u.extent);
  if (!in_plane(t, u, tolerance) && !in_plane(u, t, tolerance)) return false;
  return !edge_separates(t, u, t.normal, tolerance) && !edge_separates(u, t, t.normal, tolerance);
}

// How many triangles and pairs may be looked at: some seconds, where a file piles them up in one place.
class Effort {
 public:
  bool spend(std::uint64_t tests) {
    if (tests > left_) left_ = 0;
    else left_ -= tests;
    return left_ > 0;
  }
  bool spent() const { return left_ == 0; }

 private:
  std::uint64_t left_ = 200'000'000;
};

// Finds the pairs that coincide by halving space.
template <class Found>
class Pairs {
 public:
  Pairs(const Found& found, Effort& effort) : found_(found), effort_(effort) {}

  void find(const Triangles& a, const Triangles& b, const Bounds3& box, int depth = 0) const {
    constexpr std::size_t kFew = 64;
    constexpr int kDeepest = 40;
    if (a.empty() || b.empty()) return;
    if (a.size() * b.size() <= kFew || depth == kDeepest) return test(a, b);
    const Vec3 extent = box.extent();
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    Bounds3 low = box, high = box;
    low.max[axis] = high.min[axis] = box.center()[axis];
    const Triangles a_low = within(a, low), a_high = within(a, high), b_low = within(b, low), b_high = within(b, high);
    // Halves that hold all but a little have nothing to tell apart.
    constexpr std::size_t kHardly = 9;
    const std::uint64_t halves = a_low.size() * b_low.size() + a_high.size() * b_high.size();
    if (10 * halves > 2 * kHardly * a.size() * b.size()) return test(a, b);
    find(a_low, b_low, low, depth + 1);
    find(a_high, b_high, high, depth + 1);
  }

 private:
  static Triangles within(const Triangles& all, const Bounds3& box) {
    Triangles some;
    std::ranges::copy_if(all, std::back_inserter(some), [&](const Placed* t) { return !apart(t->box, box); });
    return some;
  }

  void test(const Triangles& a, const Triangles& b) const {
    for (const Placed* t : a) {
      if (!effort_.spend(b.size())) return;
      for (const Placed* u : b) {
        if (coincide(*t, *u)) found_(*t, *u);
      }
    }
  }

  const Found& found_;
  Effort& effort_;
};

// How the vertices of one mesh are to be moved; those at one place, which different facets have, alike.
class Moves {
 public:
  explicit Moves(const Mesh& mesh) : mesh_(mesh) {}

  /// At least by `way` in the world along a direction, with what was asked before; of opposite wishes the last.
  void ask(const Placed& placed, const Affine& to_world, const Vec3& direction, float way) {
    const glm::mat3 linear(to_world[0], to_world[1], to_world[2]);
    const glm::mat3 inverse = glm::inverse(linear);
    for (int i = 0; i < 3; ++i) {
      Vec3& move = moves_[key(mesh_.positions[mesh_.triangles[placed.triangle][i]])];
      const float missing = way - glm::dot(linear * move, direction);
      const Vec3 more = inverse * (std::max(missing, 0.0f) * direction);
      if (is_finite(more)) move += more;
    }
  }

  void apply(Mesh& mesh) const {
    for (Vec3& position : mesh.positions) {
      const auto found = moves_.find(key(position));
      if (found != moves_.end()) position += found->second;
    }
  }

 private:
  using Key = std::array<float, 3>;
  static Key key(const Vec3& p) { return {p.x, p.y, p.z}; }

  const Mesh& mesh_;
  std::map<Key, Vec3> moves_;
};

bool transmits(const Material& m) { return m.transmission > 0; }

// Whereto a triangle of glass is moved; zero where it stays, and the other one is moved. `first`: it comes before that.
Vec3 direction_of_move(const Material& glass, const Placed& t, const Material& other, const Placed& u, bool first) {
  const bool facing = glm::dot(t.normal, u.normal) < 0;
  if (!transmits(other)) return glass.thin_walled ? u.normal : -t.normal;
  if (glass.thin_walled) return !other.thin_walled || first ? u.normal : Vec3(0);
  if (other.thin_walled) return Vec3(0);
  return facing || first ? t.normal : Vec3(0);
}

class Separation {
 public:
  explicit Separation(Scene& scene) : scene_(scene), boxes_(instance_bounds(scene)) {
    for (Bounds3& box : boxes_) {
      if (!box.empty()) box = widened(box);
    }
  }

  bool complete() const { return !effort_.spent(); }

  // The moves that the instance needs, and how many of its triangles touch another.
  std::size_t of_instance(std::uint32_t i, Moves& moves) {
    std::vector<bool> touching(scene_.meshes[scene_.instances[i].mesh].triangles.size(), false);
    for (std::uint32_t j = 0; j < scene_.instances.size(); ++j) {
      if (i == j || boxes_[i].empty() || boxes_[j].empty() || apart(boxes_[i], boxes_[j])) continue;
      of_pair(i, j, moves, touching);
    }
    return static_cast<std::size_t>(std::ranges::count(touching, true));
  }

 private:
  void of_pair(std::uint32_t i, std::uint32_t j, Moves& moves, std::vector<bool>& touching) {
    const Instance &glass = scene_.instances[i], &other = scene_.instances[j];
    if (!effort_.spend(mesh(glass).triangles.size() + mesh(other).triangles.size())) return;
    const Bounds3 common{glm::max(boxes_[i].min, boxes_[j].min), glm::min(boxes_[i].max, boxes_[j].max)};
    const std::vector<Placed> a = triangles_in(scene_, glass, common), b = triangles_in(scene_, other, common);
    const auto found = [&](const Placed& t, const Placed& u) {
      touching[t.triangle] = true;
      const Vec3 direction = direction_of_move(material(glass), t, material(other), u, i < j);
      if (direction != Vec3(0)) moves.ask(t, glass.to_world, direction, kApart * std::max(t.extent, u.extent));
    };
    Pairs(found, effort_).find(pointers(a), pointers(b), common);
  }

  const Mesh& mesh(const Instance& instance) const { return scene_.meshes[instance.mesh]; }
  const Material& material(const Instance& instance) const { return scene_.materials[mesh(instance).material]; }
  static Triangles pointers(const std::vector<Placed>& triangles) {
    Triangles all;
    for (const Placed& triangle : triangles) all.push_back(&triangle);
    return all;
  }

  const Scene& scene_;
  std::vector<Bounds3> boxes_;
  Effort effort_;
};

}  // namespace

std::size_t separate_touching(Scene& scene) {
  const auto is_glass = [&](const Mesh& mesh) { return transmits(scene.materials[mesh.material]); };
  if (std::ranges::none_of(scene.meshes, is_glass)) return 0;
  Separation separation(scene);
  std::size_t touching = 0;
  std::map<std::uint32_t, Moves> moves;   // by mesh
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const std::uint32_t mesh = scene.instances[i].mesh;
    if (!is_glass(scene.meshes[mesh])) continue;
    touching += separation.of_instance(i, moves.try_emplace(mesh, scene.meshes[mesh]).first->second);
  }
  for (const auto& [mesh, all] : moves) all.apply(scene.meshes[mesh]);
  if (!separation.complete()) {
    scene.warnings.push_back("too much lies near glass to look at all of it: where surfaces coincide, rays may pass one by");
  }
  return touching;
}

}  // namespace photond
