#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/scene/gltf.h"
#include "core/scene/gltf/warnings.h"
#include "core/scene/scene.h"

namespace photond::gltf {

/// Largest magnitude of a coordinate or factor: its square must stay a finite float.
inline constexpr float kMaxMagnitude = 1e15f;

/// A checked file on its way to a Scene.
struct Build {
  const tinygltf::Model& model;
  const ResourceReader& resources;
  const SceneLimits& limits;
  Scene scene;
  Warnings warnings;

  std::map<int, std::uint32_t> images = {};                     ///< glTF image → Scene::images
  std::map<std::pair<int, bool>, std::uint32_t> textures = {};  ///< glTF texture, sRGB → Scene::textures
  /// glTF mesh, skin (−1: none), morph weights → Scene::meshes
  std::map<std::tuple<int, int, std::vector<double>>, std::vector<std::uint32_t>> meshes = {};
  std::vector<glm::dmat4> nodes_to_world = {};  ///< of all nodes, once a skin needs them
  std::set<std::string> camera_names = {};
  std::size_t next_camera = 0;         ///< no camera of a lower number can have its name from that
  std::int64_t default_material = -1;  ///< Scene::materials, once it is needed
  std::uint64_t texture_pixels = 0;
  std::uint64_t vertices = 0;         ///< read, those of morph targets, too
  std::uint64_t triangles = 0;
  std::uint64_t places = 0;            ///< of EXT_mesh_gpu_instancing, whether a mesh stands there or not
  std::uint64_t placed_triangles = 0;  ///< of all instances
  std::uint64_t emitters = 0;          ///< those among them that emit light
  std::uint64_t degenerate = 0;       ///< triangles dropped
  std::string first_degenerate = {};  ///< and where that began
};

/// Decodes images[index] unless that was done already; returns its index in Scene::images.
Result<std::uint32_t> build_image(Build& build, int index);

/// One texture reference of a material (`info` fields as tinygltf parsed them, extensions beside them).
Result<TextureSlot> build_texture(Build& build, int texture, int tex_coord, const tinygltf::Value* transform,
                                  bool srgb, const std::string& where);

/// Fills Scene::materials with all materials of the file, in its order.
Status build_materials(Build& build);

/// The meshes of the glTF mesh of a node under its morph weights and its skin, one per primitive with triangles; each
/// is built once and shared by all its instances. Skinned ones lie in the world.
Result<std::vector<std::uint32_t>> build_mesh(Build& build, const tinygltf::Node& node);

/// Whether the node has a skin and all primitives of its mesh say which joints their vertices follow.
bool is_skinned(const tinygltf::Model& model, const tinygltf::Node& node);

/// Where the joints of a skin take its meshes: from their own space to the world, in the pose that the nodes have.
Result<std::vector<glm::dmat4>> build_joints(Build& build, int skin);

/// Moves the vertices of a skinned mesh by the weighted means of their joints [glTF 2.0, 3.7.3]. Errors: a joint that
/// is not there, vertices absurdly far away.
Status apply_skin(Mesh& mesh, const Build& build, const tinygltf::Primitive& primitive,
                  const std::vector<glm::dmat4>& joints, const std::string& where);

/// The nodes that are nobody's children.
std::vector<int> parentless_nodes(const tinygltf::Model& model);

/// Walks the nodes of the chosen scene: instances, lights, cameras.
Status build_nodes(Build& build);

/// Adds a camera and a light where the file has none, each with a warning.
void add_defaults(Build& build);

/// Warns where the scene is so far from the origin that floats round its shapes.
void warn_of_far_scene(Build& build);

/// Warns of everything in the file that changes the picture and is not read.
void warn_of_ignored(Build& build);

}  // namespace photond::gltf
