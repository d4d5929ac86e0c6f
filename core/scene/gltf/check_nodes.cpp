#include "core/scene/gltf/check.h"
#include "core/scene/gltf/value.h"

namespace photond::gltf {
namespace {

Status check_references(const tinygltf::Model& model, const tinygltf::Node& node, const std::string& where) {
  if (Status s = check_index(node.mesh, model.meshes.size(), where + ".mesh", true); !s) return s;
  if (Status s = check_index(node.camera, model.cameras.size(), where + ".camera", true); !s) return s;
  if (Status s = check_index(node.skin, model.skins.size(), where + ".skin", true); !s) return s;
  const int light = static_cast<int>(number(extension(node.extensions, "KHR_lights_punctual"), "light", -1));
  const std::string light_where = where + ".extensions.KHR_lights_punctual.light";
  return check_index(light, model.lights.size(), light_where, true);
}

Status check_instancing(const tinygltf::Model& model, const tinygltf::Node& node, const std::string& where) {
  const auto* attributes = member(extension(node.extensions, "EXT_mesh_gpu_instancing"), "attributes");
  if (!attributes || !attributes->IsObject()) return Done{};
  std::size_t count = 0;
  for (const std::string& name : attributes->Keys()) {
    const std::string at = where + ".extensions.EXT_mesh_gpu_instancing.attributes." + name.substr(0, 40);
    const int index = static_cast<int>(number(attributes, name.c_str(), -1));
    if (Status s = check_index(index, model.accessors.size(), at); !s) return s;
    const tinygltf::Accessor& accessor = model.accessors[index];
    const int expected = name == "ROTATION"                         ? TINYGLTF_TYPE_VEC4
                         : name == "TRANSLATION" || name == "SCALE" ? TINYGLTF_TYPE_VEC3
                                                                    : accessor.type;
    if (accessor.type != expected) return invalid_input("accessor type is not allowed here", at);
    if (count != 0 && accessor.count != count) return invalid_input("attributes have different counts", at);
    count = accessor.count;
  }
  return Done{};
}

Status check_weights(const tinygltf::Model& model, const tinygltf::Node& node, const std::string& where) {
  if (node.weights.empty() || node.mesh < 0) return Done{};
  for (const tinygltf::Primitive& primitive : model.meshes[node.mesh].primitives) {
    if (primitive.targets.size() != node.weights.size()) {
      return invalid_input("there must be one weight per morph target", where + ".weights");
    }
  }
  return Done{};
}

Status check_skin(const tinygltf::Model& model, const tinygltf::Skin& skin, const std::string& where) {
  constexpr std::size_t kMostJoints = 65'536;  // as many as JOINTS_0 can tell apart
  if (skin.joints.size() > kMostJoints) return invalid_input("there are too many joints", where + ".joints");
  for (std::size_t j = 0; j < skin.joints.size(); ++j) {
    if (Status s = check_index(skin.joints[j], model.nodes.size(), where + "." + place("joints", j)); !s) return s;
  }
  const std::string matrices = where + ".inverseBindMatrices";
  if (Status s = check_index(skin.inverseBindMatrices, model.accessors.size(), matrices, true); !s) return s;
  if (skin.inverseBindMatrices < 0) return Done{};
  const tinygltf::Accessor& accessor = model.accessors[skin.inverseBindMatrices];
  if (accessor.type != TINYGLTF_TYPE_MAT4 || accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT) {
    return invalid_input("inverse bind matrices must be 4x4 floats", matrices);
  }
  if (accessor.count < skin.joints.size()) return invalid_input("there must be one matrix per joint", matrices);
  return Done{};
}

/// Every node has at most one parent; returns the parents (−1: none).
Result<std::vector<int>> find_parents(const tinygltf::Model& model) {
  std::vector<int> parents(model.nodes.size(), -1);
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    const std::vector<int>& children = model.nodes[i].children;
    for (std::size_t c = 0; c < children.size(); ++c) {
      const std::string where = place("nodes", i) + "." + place("children", c);
      if (Status s = check_index(children[c], model.nodes.size(), where); !s) return s.error();
      if (parents[children[c]] != -1) return invalid_input("node has two parents", where);
      parents[children[c]] = static_cast<int>(i);
    }
  }
  return parents;
}

/// With one parent each, a cycle is a chain of parents that comes back to itself.
Status check_acyclic(const std::vector<int>& parents) {
  std::vector<std::size_t> visited_by(parents.size(), 0);
  for (std::size_t start = 0; start < parents.size(); ++start) {
    int at = static_cast<int>(start);
    while (at != -1 && visited_by[at] == 0) {
      visited_by[at] = start + 1;
      at = parents[at];
    }
    if (at != -1 && visited_by[at] == start + 1) {
      return invalid_input("node is its own ancestor", place("nodes", static_cast<std::size_t>(at)));
    }
  }
  return Done{};
}

}  // namespace

Status check_nodes(const tinygltf::Model& model) {
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    const std::string where = place("nodes", i);
    if (Status s = check_references(model, model.nodes[i], where); !s) return s;
    if (Status s = check_instancing(model, model.nodes[i], where); !s) return s;
    if (Status s = check_weights(model, model.nodes[i], where); !s) return s;
  }
  for (std::size_t i = 0; i < model.skins.size(); ++i) {
    if (Status s = check_skin(model, model.skins[i], place("skins", i)); !s) return s;
  }
  const Result<std::vector<int>> parents = find_parents(model);
  if (!parents) return parents.error();
  return check_acyclic(*parents);
}

Status check_scenes(const tinygltf::Model& model) {
  if (Status s = check_index(model.defaultScene, model.scenes.size(), "scene", true); !s) return s;
  std::vector<bool> is_child(model.nodes.size(), false);
  for (const tinygltf::Node& node : model.nodes) {
    for (int child : node.children) is_child[child] = true;
  }
  std::vector<std::size_t> seen_in(model.nodes.size(), 0);
  for (std::size_t i = 0; i < model.scenes.size(); ++i) {
    const std::vector<int>& nodes = model.scenes[i].nodes;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const std::string where = place("scenes", i) + "." + place("nodes", n);
      if (Status s = check_index(nodes[n], model.nodes.size(), where); !s) return s;
      if (is_child[nodes[n]]) return invalid_input("node is not a root", where);
      if (seen_in[nodes[n]] == i + 1) return invalid_input("node appears twice", where);
      seen_in[nodes[n]] = i + 1;
    }
  }
  return Done{};
}

}  // namespace photond::gltf
