#include "core/trace/prepare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>

#include "core/math/transform.h"
#include "core/trace/casters.h"
#include "core/trace/nested.h"
#include "core/trace/touching.h"

namespace photond {

namespace {

std::vector<std::uint32_t> mesh_uses(const Scene& scene) {
  std::vector<std::uint32_t> uses(scene.meshes.size(), 0);
  for (const Instance& instance : scene.instances) ++uses[instance.mesh];
  return uses;
}

void move_to_world(Mesh& mesh, const Affine& m) {
  const bool mirrored = is_mirrored(m);
  for (Vec3& p : mesh.positions) p = transform_point(m, p);
  for (Vec3& n : mesh.normals) {
    const Vec3 moved = transform_normal(m, n);
    const float length = glm::length(moved);
    if (length > 0) n = moved / length;
  }
  for (Vec4& t : mesh.tangents) t = Vec4(transform_vector(m, Vec3(t)), mirrored ? -t.w : t.w);
  if (mirrored) {
    for (glm::uvec3& triangle : mesh.triangles) std::swap(triangle.y, triangle.z);
  }
}

// Floats far from the origin are coarse, for rays more than for the places of things: a scene whose distance exceeds
// its size by this factor, and so loses four of 24 bits, is moved to the origin.
constexpr float kFar = 16;

void recentre(Scene& scene) {
  const Bounds3 bounds = world_bounds(scene);
  if (bounds.empty() || max_component(glm::abs(bounds.center())) <= kFar * bounds.radius()) return;
  scene.origin = bounds.center();
  for (Instance& instance : scene.instances) instance.to_world[3] -= scene.origin;
  for (PunctualLight& light : scene.lights) light.position -= scene.origin;
}

// A mesh placed once is put there for good: its rays and shading need no transform.
void place_single_meshes(Scene& scene) {
  const std::vector<std::uint32_t> uses = mesh_uses(scene);
  for (Instance& instance : scene.instances) {
    instance.moved = instance.to_world != Affine(1);
    if (uses[instance.mesh] != 1 || !instance.moved) continue;
    move_to_world(scene.meshes[instance.mesh], instance.to_world);
    instance.to_world = Affine(1);
    instance.moved = false;
  }
}

void make_vertices(Scene& scene) {
  for (Mesh& mesh : scene.meshes) {
    mesh.vertices.resize(mesh.positions.size());
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      mesh.vertices[i] = {mesh.positions[i], mesh.normals.empty() ? Vec3(0) : mesh.normals[i]};
    }
  }
}

// The corners from the least one on, in the triangle's own direction; in any direction where both sides shine.
using Corners = std::array<std::array<float, 3>, 3>;
Corners canonical_corners(const Mesh& mesh, const glm::uvec3& triangle, bool double_sided) {
  Corners corners;
  for (int i = 0; i < 3; ++i) {
    const Vec3& p = mesh.positions[triangle[i]];
    corners[static_cast<std::size_t>(i)] = {p.x, p.y, p.z};
  }
  if (double_sided) {
    std::sort(corners.begin(), corners.end());
  } else {
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  }
  return corners;
}

bool emissive(const Scene& scene, const Mesh& mesh) { return scene.materials[mesh.material].emissive(); }

// A lamp that lies twice in one place shines once. Placements of one mesh with one transform: the first is kept.
std::size_t drop_repeated_lamps(Scene& scene) {
  std::set<std::pair<std::uint32_t, std::array<float, 12>>> seen;
  return std::erase_if(scene.instances, [&](const Instance& instance) {
    if (!emissive(scene, scene.meshes[instance.mesh])) return false;
    std::array<float, 12> transform;
    for (int i = 0; i < 12; ++i) transform[static_cast<std::size_t>(i)] = instance.to_world[i / 3][i % 3];
    return !seen.emplace(instance.mesh, transform).second;
  });
}

// Emissive triangles that coincide, within a mesh or among the meshes placed once, which stand in the world: the first
// is kept.
std::size_t drop_coincident_emitters(Scene& scene) {
  const std::vector<std::uint32_t> uses = mesh_uses(scene);
  std::set<Corners> world;
  std::size_t dropped = 0;
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    Mesh& mesh = scene.meshes[i];
    if (!emissive(scene, mesh) || uses[i] == 0) continue;
    std::set<Corners> own;
    std::set<Corners>& seen = uses[i] == 1 ? world : own;
    const bool double_sided = scene.materials[mesh.material].double_sided;
    dropped += std::erase_if(mesh.triangles, [&](const glm::uvec3& t) {
      return !seen.insert(canonical_corners(mesh, t, double_sided)).second;
    });
  }
  std::erase_if(scene.instances, [&](const Instance& i) { return scene.meshes[i.mesh].triangles.empty(); });
  return dropped;
}

void warn_of_dropped(Scene& scene, std::size_t dropped) {
  if (dropped > 0) scene.warnings.push_back("emitters that coincide with others are left out: " + std::to_string(dropped));
}

template <class T>
std::uint64_t bytes_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

std::uint64_t scene_bytes(const Scene& scene) {
  std::uint64_t bytes = 0;
  for (const Mesh& mesh : scene.meshes) {
    bytes += bytes_of(mesh.positions) + bytes_of(mesh.normals) + bytes_of(mesh.tangents) + bytes_of(mesh.uv[0]) +
             bytes_of(mesh.uv[1]) + bytes_of(mesh.colors) + bytes_of(mesh.triangles) + bytes_of(mesh.vertices);
  }
  for (const TextureImage& image : scene.images) bytes += bytes_of(image.u8) + bytes_of(image.u16);
  if (scene.environment.map != nullptr) bytes += scene.environment.map->memory_bytes();
  return bytes + bytes_of(scene.meshes) + bytes_of(scene.instances) + bytes_of(scene.materials) +
         bytes_of(scene.textures) + bytes_of(scene.lights) + bytes_of(scene.cameras);
}

}  // namespace

Result<std::shared_ptr<const PreparedScene>> prepare(Scene scene, const Execution& execution) {
  if (execution.cancelled()) return cancelled();
  auto prepared = std::make_shared<PreparedScene>();
  prepared->digest = scene_digest(scene);
  prepared->scene = std::move(scene);
  recentre(prepared->scene);
  std::size_t dropped = drop_repeated_lamps(prepared->scene);
  place_single_meshes(prepared->scene);
  dropped += drop_coincident_emitters(prepared->scene);
  warn_of_dropped(prepared->scene, dropped);
  prepared->touching_glass = separate_touching(prepared->scene);
  find_nested(prepared->scene);
  make_vertices(prepared->scene);
  prepared->bounds = world_bounds(prepared->scene);
  for (const Instance& instance : prepared->scene.instances) {
    prepared->triangle_count += prepared->scene.meshes[instance.mesh].triangles.size();
  }
  prepared->placed = placed_meshes(prepared->scene);
  prepared->lights = Lights(prepared->scene, prepared->bounds);
  prepared->shares_gloss = lights_gloss(prepared->scene) && prepared->lights.casting_share() > 0;
  if (execution.cancelled()) return cancelled();
  // Inside the arena Embree's build tasks run on its low-priority workers.
  Result<Accel> accel = execution.arena == nullptr
                            ? Accel::build(prepared->scene)
                            : execution.arena->execute([&] { return Accel::build(prepared->scene); });
  if (!accel) return accel.error();
  prepared->accel = std::move(accel).value();
  prepared->light_media = find_light_media(prepared->scene, prepared->accel, prepared->lights, execution);
  prepared->domain = find_domains(prepared->scene, prepared->bounds, prepared->accel, prepared->lights, execution);
  prepared->aim = learn_aim(prepared->scene, prepared->accel, prepared->lights, execution);
  // By the root: pictures profit by less noise, and by more passes in the same time.
  prepared->directed_share = std::sqrt(prepared->domain.effort * prepared->aim.effort);
  prepared->memory_bytes = scene_bytes(prepared->scene) + prepared->accel.memory_bytes() +
                           prepared->lights.memory_bytes() + prepared->light_media.memory_bytes() +
                           bytes_of(prepared->placed);
  if (execution.cancelled()) return cancelled();
  return std::shared_ptr<const PreparedScene>(std::move(prepared));
}

}  // namespace photond
