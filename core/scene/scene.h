#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/digest.h"
#include "core/math/types.h"
#include "core/scene/camera.h"
#include "core/scene/environment.h"
#include "core/scene/material.h"

namespace photond {

/// Decoded pixels of a texture file, RGBA, first row on top; exactly one of `u8` and `u16` is filled.
struct TextureImage {
  std::string name;
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> u8;     ///< 4·width·height values
  std::vector<std::uint16_t> u16;   ///< 4·width·height values
};

enum class Wrap : std::uint8_t { repeat, clamp, mirror };

/// An image with its sampler. `srgb` says how RGB values are decoded (A is always linear); an image used both
/// as colour and as data appears as two textures.
struct Texture {
  std::uint32_t image = 0;          ///< index into Scene::images
  Wrap wrap_s = Wrap::repeat;
  Wrap wrap_t = Wrap::repeat;
  bool nearest = false;             ///< magnification filter; otherwise bilinear
  bool srgb = false;
};

/// What rays need of a vertex, in half a cache line.
struct alignas(32) Vertex {
  Vec3 position;
  Vec3 normal;                      ///< zero where the mesh has none
};

/// Triangles with one material, in object space. Attribute vectors are empty or one value per vertex.
struct Mesh {
  std::string name;
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;        ///< unit; empty: flat shading
  std::vector<Vec4> tangents;       ///< xyz unit, w = ±1 handedness
  std::vector<Vec2> uv[2];
  std::vector<Vec4> colors;         ///< linear COLOR_0
  std::vector<glm::uvec3> triangles;
  std::uint32_t material = 0;       ///< index into Scene::materials
  std::vector<Vertex> vertices;     ///< made by `prepare`: positions and normals once more, side by side
};

/// One placement of a mesh in the world.
struct Instance {
  std::uint32_t mesh = 0;
  Affine to_world{1};
  bool moved = true;      ///< false where `prepare` has found to_world to be the identity
};

enum class LightType : std::uint8_t { point, spot, directional };

/// KHR_lights_punctual, placed in the world. Values are taken as radiometric, as given.
struct PunctualLight {
  std::string name;
  LightType type = LightType::point;
  Vec3 position{0};
  Vec3 direction{0, 0, -1};         ///< unit; the way the light shines (spot, directional)
  Rgb intensity{1};                 ///< W·sr⁻¹ (point, spot) or W·m⁻² (directional): colour × intensity
  double cos_inner = 1;             ///< spot: full intensity inside
  double cos_outer = 0.70710678;    ///< spot: none outside

  /// 1 − cos of a spot's angles, which keeps its digits where a beam is narrow.
  float inner_height() const { return static_cast<float>(1 - cos_inner); }
  float outer_height() const { return static_cast<float>(1 - cos_outer); }
  /// glTF's cone attenuation in a unit direction away from the light: the square of the cosine's position between outer
  /// and inner angle; 1 but for spots.
  float attenuation(const Vec3& away) const {
    if (type != LightType::spot) return 1;
    const Vec3 beside = away - direction;
    const float height = 0.5f * glm::dot(beside, beside);
    if (height <= inner_height()) return 1;
    if (height >= outer_height()) return 0;
    const float t = (outer_height() - height) / (outer_height() - inner_height());
    return t * t;
  }
};

/// Everything a picture needs, as plain data; what read_gltf returns.
struct Scene {
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  std::vector<Material> materials;
  std::vector<Texture> textures;
  std::vector<TextureImage> images;
  std::vector<PunctualLight> lights;
  std::vector<Camera> cameras;      ///< never empty after read_gltf
  Environment environment;
  Vec3 origin{0};                   ///< where instances and lights have their origin in the file's coordinates, which
                                    ///< the cameras keep; not zero only where `prepare` has moved a far scene
  std::vector<std::string> warnings;  ///< each names its place: "materials[2]: KHR_materials_sheen ignored"
};

/// What read_gltf warns of where it assumes an environment.
inline constexpr const char* kNoLightWarning = "the file has no light: a uniform white environment lights the scene";

/// Replaces the scene's environment, an assumed one with its warning, too; the map's own warnings come in.
void set_environment(Scene& scene, Environment environment);

/// Bounds of each instance in the world; empty where its mesh is.
std::vector<Bounds3> instance_bounds(const Scene& scene);

/// Bounds of all instances in the world.
Bounds3 world_bounds(const Scene& scene);

/// SHA-256 of everything that changes a photon map: geometry, materials, textures, lights and environment, but
/// neither cameras, names nor warnings.
Digest scene_digest(const Scene& scene);

}  // namespace photond
