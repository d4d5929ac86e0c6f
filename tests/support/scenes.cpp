#include "tests/support/scenes.h"

#include <cassert>
#include <cmath>

#include "core/math/frame.h"

namespace photond::test {

Material lambert(const Rgb& albedo) {
  Material m;
  m.name = "lambert";
  m.base_color = albedo;
  m.metallic = 0;
  m.specular = 0;
  m.double_sided = true;
  return m;
}

Material emitter(const Rgb& radiance) {
  Material m = lambert(Rgb(0));
  m.name = "emitter";
  m.emission = radiance;
  m.double_sided = false;
  return m;
}

Material mirror(const Rgb& reflectance) {
  Material m;
  m.name = "mirror";
  m.base_color = reflectance;
  m.metallic = 1;
  m.roughness = 0;
  return m;
}

Material glass(float ior) {
  Material m;
  m.name = "glass";
  m.metallic = 0;
  m.roughness = 0;
  m.transmission = 1;
  m.thin_walled = false;
  m.ior = ior;
  return m;
}

Scene empty_scene() {
  Scene scene;
  scene.cameras.push_back(look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 0.7f));
  return scene;
}

std::uint32_t add_material(Scene& scene, const Material& material) {
  scene.materials.push_back(material);
  return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

std::uint32_t add_mesh(Scene& scene, Mesh mesh, std::uint32_t material) {
  mesh.material = material;
  scene.meshes.push_back(std::move(mesh));
  const auto index = static_cast<std::uint32_t>(scene.meshes.size() - 1);
  scene.instances.push_back({index, Affine(1)});
  return index;
}

Mesh parallelogram(const Vec3& origin, const Vec3& a, const Vec3& b) {
  Mesh mesh;
  mesh.positions = {origin, origin + a, origin + a + b, origin + b};
  mesh.uv[0] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

Mesh box(const Vec3& min, const Vec3& max, bool inwards) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back({(i & 1) ? max.x : min.x, (i & 2) ? max.y : min.y, (i & 4) ? max.z : min.z});
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  if (inwards) {
    for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
  }
  return mesh;
}

Mesh sphere(const Vec3& center, float radius, int rings) {
  Mesh mesh;
  const int segments = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    const float theta = kPi * static_cast<float>(i) / static_cast<float>(rings);
    for (int j = 0; j <= segments; ++j) {
      const float phi = 2 * kPi * static_cast<float>(j) / static_cast<float>(segments);
      const Vec3 n{std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi)};
      mesh.positions.push_back(center + radius * n);
      mesh.normals.push_back(n);
    }
  }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (segments + 1) + j); };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < segments; ++j) {
      if (i > 0) mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + 1 < rings) mesh.triangles.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
  }
  return mesh;
}

Mesh disk(const Vec3& center, const Vec3& normal, float radius, int segments) {
  const Frame frame(normal);
  Mesh mesh;
  mesh.positions.push_back(center);
  for (int i = 0; i < segments; ++i) {
    const float phi = 2 * kPi * static_cast<float>(i) / static_cast<float>(segments);
    mesh.positions.push_back(center + radius * (std::cos(phi) * frame.s + std::sin(phi) * frame.t));
    mesh.triangles.push_back({0, static_cast<std::uint32_t>(i + 1), static_cast<std::uint32_t>((i + 1) % segments + 1)});
  }
  return mesh;
}

Mesh faceted(Mesh mesh) {
  mesh.normals.clear();
  return mesh;
}

Mesh inside_out(Mesh mesh) {
  for (Vec3& n : mesh.normals) n = -n;
  for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
  return mesh;
}

void add_point_light(Scene& scene, const Vec3& position, const Rgb& intensity) {
  PunctualLight light;
  light.position = position;
  light.intensity = intensity;
  scene.lights.push_back(light);
}

PunctualLight spot_light(const Vec3& position, const Vec3& direction, float cos_inner, float cos_outer, float intensity) {
  PunctualLight spot;
  spot.type = LightType::spot;
  spot.position = position;
  spot.direction = glm::normalize(direction);
  spot.cos_inner = cos_inner;
  spot.cos_outer = cos_outer;
  spot.intensity = Rgb(intensity);
  return spot;
}

std::shared_ptr<const PreparedScene> prepared(Scene scene) {
  auto result = prepare(std::move(scene), Execution{});
  assert(result.ok());
  return std::move(result).value();
}

std::shared_ptr<const PreparedScene> busy_room() {
  Scene scene = empty_scene();
  add_mesh(scene, box({-2, -2, 0}, {2, 2, 3}, true), add_material(scene, lambert({0.8f, 0.5f, 0.3f})));
  scene.meshes[0].triangles.resize(10);  // one side is open
  Material coated;
  coated.metallic = 0.2f;
  coated.roughness = 0.3f;
  add_mesh(scene, sphere({-1, 0, 0.6f}, 0.5f), add_material(scene, coated));
  Material amber = glass(1.5f);
  amber.roughness = 0.2f;
  amber.attenuation_color = {0.9f, 0.5f, 0.1f};
  amber.attenuation_distance = 0.5f;
  add_mesh(scene, sphere({1, 0, 0.6f}, 0.5f), add_material(scene, amber));
  add_mesh(scene, sphere({0, 1, 0.6f}, 0.5f), add_material(scene, mirror(Rgb(0.9f))));
  add_mesh(scene, parallelogram({-0.5f, -0.5f, 2.9f}, {0, 1, 0}, {1, 0, 0}),
                 add_material(scene, emitter({5, 4, 3})));
  add_point_light(scene, {0, -1, 2}, {3, 3, 6});
  scene.environment.radiance = Rgb(0.2f);
  return prepared(std::move(scene));
}

const Workers& workers() {
  static const Workers instance(2);
  return instance;
}

}  // namespace photond::test
