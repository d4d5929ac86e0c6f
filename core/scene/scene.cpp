#include "core/scene/scene.h"

#include <span>
#include <utility>

namespace photond {
namespace {

Bounds3 object_bounds(const Mesh& mesh) {
  Bounds3 bounds;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int corner = 0; corner < 3; ++corner) bounds.add(mesh.positions[t[corner]]);
  }
  return bounds;
}

/// Feeds values to a hasher member by member, so that neither padding nor names take part.
struct SceneHasher {
  Hasher hasher;

  template <class T>
  void value(const T& v) {
    hasher.update_value(v);
  }
  template <class T>
  void values(const std::vector<T>& v) {
    value(static_cast<std::uint64_t>(v.size()));
    hasher.update(std::as_bytes(std::span<const T>(v)));
  }

  void mesh(const Mesh& m) {
    values(m.positions);
    values(m.normals);
    values(m.tangents);
    values(m.uv[0]);
    values(m.uv[1]);
    values(m.colors);
    values(m.triangles);
    value(m.material);
  }
  void slot(const TextureSlot& s) {
    value(s.texture);
    value(s.uv_set);
    value(s.uv_transform);
  }
  void material(const Material& m) {
    value(m.base_color);
    value(m.alpha);
    slot(m.base_color_texture);
    value(m.metallic);
    value(m.roughness);
    slot(m.metallic_roughness_texture);
    slot(m.normal_texture);
    value(m.normal_scale);
    value(m.emission);
    slot(m.emission_texture);
    value(m.alpha_mode);
    value(m.alpha_cutoff);
    value(m.double_sided);
    value(m.ior);
    value(m.specular);
    slot(m.specular_texture);
    value(m.specular_color);
    slot(m.specular_color_texture);
    value(m.transmission);
    slot(m.transmission_texture);
    value(m.thin_walled);
    value(m.attenuation_color);
    value(m.attenuation_distance);
    value(m.dispersion);
    value(m.anisotropy);
    value(m.anisotropy_rotation);
    slot(m.anisotropy_texture);
    value(m.clearcoat);
    slot(m.clearcoat_texture);
    value(m.clearcoat_roughness);
    slot(m.clearcoat_roughness_texture);
    slot(m.clearcoat_normal_texture);
    value(m.clearcoat_normal_scale);
    value(m.sheen_color);
    slot(m.sheen_color_texture);
    value(m.sheen_roughness);
    slot(m.sheen_roughness_texture);
  }
  void texture(const Texture& t) {
    value(t.image);
    value(t.wrap_s);
    value(t.wrap_t);
    value(t.nearest);
    value(t.srgb);
  }
  void image(const TextureImage& i) {
    value(i.width);
    value(i.height);
    values(i.u8);
    values(i.u16);
  }
  void light(const PunctualLight& l) {
    value(l.type);
    value(l.position);
    value(l.direction);
    value(l.intensity);
    value(l.cos_inner);
    value(l.cos_outer);
  }
  void instance(const Instance& i) {
    value(i.mesh);
    value(i.to_world);
  }

  template <class T>
  void all(const std::vector<T>& items, void (SceneHasher::*add)(const T&)) {
    value(static_cast<std::uint64_t>(items.size()));
    for (const T& item : items) (this->*add)(item);
  }
};

}  // namespace

void set_environment(Scene& scene, Environment environment) {
  std::erase_if(scene.warnings, [](const std::string& warning) { return warning.ends_with(kNoLightWarning); });
  scene.environment = std::move(environment);
  if (scene.environment.map == nullptr) return;
  const std::vector<std::string>& warnings = scene.environment.map->warnings;
  scene.warnings.insert(scene.warnings.end(), warnings.begin(), warnings.end());
}

std::vector<Bounds3> instance_bounds(const Scene& scene) {
  std::vector<Bounds3> objects;
  for (const Mesh& mesh : scene.meshes) objects.push_back(object_bounds(mesh));
  std::vector<Bounds3> bounds(scene.instances.size());
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const Bounds3& object = objects[instance.mesh];
    if (object.empty()) continue;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 p(corner & 1 ? object.max.x : object.min.x, corner & 2 ? object.max.y : object.min.y,
                   corner & 4 ? object.max.z : object.min.z);
      bounds[i].add(transform_point(instance.to_world, p));
    }
  }
  return bounds;
}

Bounds3 world_bounds(const Scene& scene) {
  Bounds3 world;
  for (const Bounds3& bounds : instance_bounds(scene)) {
    world.min = glm::min(world.min, bounds.min);
    world.max = glm::max(world.max, bounds.max);
  }
  return world;
}

Digest scene_digest(const Scene& scene) {
  SceneHasher hash;
  hash.hasher.update("photond scene 1");
  hash.all(scene.meshes, &SceneHasher::mesh);
  hash.all(scene.instances, &SceneHasher::instance);
  hash.all(scene.materials, &SceneHasher::material);
  hash.all(scene.textures, &SceneHasher::texture);
  hash.all(scene.images, &SceneHasher::image);
  hash.all(scene.lights, &SceneHasher::light);
  hash.value(scene.environment.radiance);
  if (scene.environment.map != nullptr) {
    hash.value(scene.environment.map->digest());
    hash.value(scene.environment.rotation);
  }
  return hash.hasher.finish();
}

}  // namespace photond
