#include <algorithm>
#include <cmath>

#include "core/scene/gltf/accessor.h"
#include "core/scene/gltf/build.h"
#include "core/scene/gltf/check.h"
#include "core/scene/gltf/transform.h"
#include "core/scene/gltf/value.h"

namespace photond::gltf {
namespace {

std::string name_or(const std::string& first, const std::string& second, const std::string& last) {
  if (!first.empty()) return first;
  return !second.empty() ? second : last;
}

/// `wanted`, or a name by number where that is empty or another camera's.
std::string camera_name(Build& build, const std::string& wanted) {
  std::string name = wanted;
  build.next_camera = std::max(build.next_camera, build.scene.cameras.size());
  while (name.empty() || !build.camera_names.insert(name).second) {
    name = "camera " + std::to_string(build.next_camera++);
  }
  return name;
}

Status add_camera(Build& build, const tinygltf::Node& node, const glm::dmat4& to_world,
                  const std::string& where) {
  const tinygltf::Camera& from = build.model.cameras[node.camera];
  const auto frame = to_frame(to_world, where);
  if (!frame) return frame.error();
  if (!frame->has_value()) {
    build.warnings.add("transform leaves the camera no direction: it is left out", where);
    return Done{};
  }
  Camera camera{.name = camera_name(build, name_or(from.name, node.name, "")), .to_world = **frame};
  camera.orthographic = from.type == "orthographic";
  if (camera.orthographic) {
    const double ymag = std::abs(from.orthographic.ymag);
    if (!(ymag <= kMaxMagnitude)) return invalid_input("ymag is absurdly large", where + ".camera");
    camera.ymag = static_cast<float>(ymag);
  } else {
    camera.yfov = static_cast<float>(from.perspective.yfov);
  }
  build.scene.cameras.push_back(std::move(camera));
  return Done{};
}

Result<Rgb> light_intensity(const tinygltf::Light& from, const std::string& where) {
  Rgb color(1);
  if (from.color.size() == 3) color = Rgb(from.color[0], from.color[1], from.color[2]);
  const Rgb intensity = color * static_cast<float>(from.intensity);
  if (!(max_component(intensity) <= kMaxMagnitude)) return invalid_input("light is absurdly bright", where);
  return intensity;
}

Status add_light(Build& build, const tinygltf::Node& node, int index, const glm::dmat4& to_world,
                 const std::string& where) {
  const tinygltf::Light& from = build.model.lights[index];
  const std::string light_where =
      "extensions.KHR_lights_punctual." + place("lights", static_cast<std::size_t>(index));
  const Result<Rgb> intensity = light_intensity(from, light_where);
  if (!intensity) return intensity.error();
  const auto frame = to_frame(to_world, where);
  if (!frame) return frame.error();
  if (!frame->has_value() && from.type != "point") {
    build.warnings.add("transform leaves the light no direction: it is left out", where);
    return Done{};
  }
  PunctualLight light{
      .name = name_or(from.name, node.name, "light " + std::to_string(build.scene.lights.size())),
      .position = Vec3(glm::dvec3(to_world[3])),
      .intensity = *intensity};
  if (frame->has_value()) light.direction = -(**frame)[2];
  if (from.type == "directional") light.type = LightType::directional;
  if (from.type == "spot") {
    light.type = LightType::spot;
    light.cos_inner = std::cos(from.spot.innerConeAngle);
    light.cos_outer = std::cos(from.spot.outerConeAngle);
  }
  build.scene.lights.push_back(std::move(light));
  return Done{};
}

/// Counts a mesh that is placed against the limits.
Status account(Build& build, const Mesh& mesh, const std::string& where) {
  const auto too_many = [&](const char* what) {
    return Error{ErrorCode::limit_exceeded, std::string("the file places too many triangles ") + what, where};
  };
  build.placed_triangles += mesh.triangles.size();
  if (build.placed_triangles > build.limits.max_placed_triangles) return too_many("in the scene");
  if (build.scene.materials[mesh.material].emissive()) build.emitters += mesh.triangles.size();
  if (build.emitters > build.limits.max_emitters) return too_many("that emit light");
  return Done{};
}

Status add_instance(Build& build, const std::vector<std::uint32_t>& meshes, glm::dmat4 to_world,
                    const std::string& where) {
  // Planes are often scaled by 0 along the axis that they do not extend along.
  if (is_singular(to_world)) to_world = thickened(to_world);
  if (is_singular(to_world)) {
    build.warnings.add("transform leaves nothing of the mesh, which is left out", where);
    return Done{};
  }
  const Result<Affine> affine = to_affine(to_world, where);
  if (!affine) return affine.error();
  for (std::uint32_t mesh : meshes) {
    if (build.scene.instances.size() >= build.limits.max_instances) {
      return Error{ErrorCode::limit_exceeded, "the file has too many instances", where};
    }
    if (Status s = account(build, build.scene.meshes[mesh], where); !s) return s;
    build.scene.instances.push_back({mesh, *affine});
  }
  return Done{};
}

/// EXT_mesh_gpu_instancing: one attribute of all placements, `otherwise` repeated where it is absent.
template <class V>
Result<std::vector<V>> instance_attribute(const Build& build, const tinygltf::Value* attributes,
                                          const char* name, std::size_t count, const V& otherwise) {
  std::vector<V> out(count, otherwise);
  const int accessor = static_cast<int>(number(attributes, name, -1));
  if (accessor < 0) return out;
  const Result<std::vector<float>> values =
      read_floats(build.model, accessor, static_cast<std::size_t>(V::length()), kMaxMagnitude);
  if (!values) return values.error();
  for (std::size_t i = 0; i < values->size(); ++i) {
    out[i / V::length()][static_cast<int>(i % V::length())] = (*values)[i];
  }
  return out;
}

Status add_gpu_instances(Build& build, const tinygltf::Value* attributes,
                         const std::vector<std::uint32_t>& meshes, const glm::dmat4& to_world,
                         const std::string& where) {
  std::size_t count = 0;
  for (const std::string& name : attributes->Keys()) {
    count = build.model.accessors[static_cast<int>(number(attributes, name.c_str(), 0))].count;
  }
  build.places += count;
  if (build.places > build.limits.max_instances) {
    return Error{ErrorCode::limit_exceeded, "the file has too many instances", where};
  }
  const auto translation = instance_attribute(build, attributes, "TRANSLATION", count, Vec3(0));
  if (!translation) return translation.error();
  const auto rotation = instance_attribute(build, attributes, "ROTATION", count, Vec4(0, 0, 0, 1));
  if (!rotation) return rotation.error();
  const auto scale = instance_attribute(build, attributes, "SCALE", count, Vec3(1));
  if (!scale) return scale.error();
  for (std::size_t i = 0; i < count; ++i) {
    if (!(glm::length((*rotation)[i]) > 1e-6f)) {
      return invalid_input("rotation is not a unit quaternion", where + ".extensions.EXT_mesh_gpu_instancing");
    }
    const glm::dmat4 local = compose((*translation)[i], (*rotation)[i], (*scale)[i]);
    if (Status s = add_instance(build, meshes, to_world * local, where); !s) return s;
  }
  return Done{};
}

Status add_mesh(Build& build, const tinygltf::Node& node, const glm::dmat4& to_world,
                const std::string& where) {
  const bool skinned = is_skinned(build.model, node);
  if (node.skin >= 0 && !skinned) build.warnings.add("skin of a mesh without joints and weights ignored", where);
  const Result<std::vector<std::uint32_t>> meshes = build_mesh(build, node);
  if (!meshes) return meshes.error();
  // Its joints have taken it to the world already, wherever the node is.
  if (skinned) return add_instance(build, *meshes, glm::dmat4(1), where);
  const auto* attributes = member(extension(node.extensions, "EXT_mesh_gpu_instancing"), "attributes");
  if (attributes && attributes->IsObject()) {
    return add_gpu_instances(build, attributes, *meshes, to_world, where);
  }
  return add_instance(build, *meshes, to_world, where);
}

Status add_node(Build& build, const tinygltf::Node& node, const glm::dmat4& to_world,
                const std::string& where) {
  if (node.mesh >= 0) {
    if (Status s = add_mesh(build, node, to_world, where); !s) return s;
  }
  if (node.camera >= 0) {
    if (Status s = add_camera(build, node, to_world, where); !s) return s;
  }
  const int light = static_cast<int>(number(extension(node.extensions, "KHR_lights_punctual"), "light", -1));
  return light >= 0 ? add_light(build, node, light, to_world, where) : Status(Done{});
}

/// The root nodes of the default scene, of the first, or of the whole file where it has no scenes.
std::vector<int> root_nodes(Build& build) {
  const tinygltf::Model& model = build.model;
  if (!model.scenes.empty()) {
    const auto chosen = static_cast<std::size_t>(std::max(model.defaultScene, 0));
    if (model.scenes.size() > 1)
      build.warnings.add("only this scene of several is shown", place("scenes", chosen));
    return model.scenes[chosen].nodes;
  }
  build.warnings.add("the file has no scene: all its nodes are shown", "scenes");
  return parentless_nodes(model);
}

}  // namespace

std::vector<int> parentless_nodes(const tinygltf::Model& model) {
  std::vector<bool> is_child(model.nodes.size(), false);
  for (const tinygltf::Node& node : model.nodes) {
    for (int child : node.children) is_child[child] = true;
  }
  std::vector<int> roots;
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    if (!is_child[i]) roots.push_back(static_cast<int>(i));
  }
  return roots;
}

Status build_nodes(Build& build) {
  struct Visit {
    int node;
    glm::dmat4 parent_to_world;
  };
  std::vector<Visit> stack;
  // An explicit stack, since a chain of nodes may be as long as the file; reversed, to keep the file's order.
  const auto push = [&stack](const std::vector<int>& nodes, const glm::dmat4& to_world) {
    for (auto it = nodes.rbegin(); it != nodes.rend(); ++it) stack.push_back({*it, to_world});
  };
  push(root_nodes(build), glm::dmat4(1));
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    const tinygltf::Node& node = build.model.nodes[visit.node];
    const std::string where = place("nodes", static_cast<std::size_t>(visit.node));
    const Result<glm::dmat4> local = local_transform(node, where);
    if (!local) return local.error();
    const glm::dmat4 to_world = visit.parent_to_world * *local;
    if (Status s = add_node(build, node, to_world, where); !s) return s;
    push(node.children, to_world);
  }
  return Done{};
}

}  // namespace photond::gltf
