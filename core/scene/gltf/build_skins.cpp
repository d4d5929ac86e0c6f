// Skins in the pose that the nodes of the file have.
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/scene/gltf/accessor.h"
#include "core/scene/gltf/build.h"
#include "core/scene/gltf/check.h"
#include "core/scene/gltf/transform.h"

namespace photond::gltf {
namespace {

/// Four joints of each vertex and their weights.
struct Influences {
  std::vector<float> joints, weights;
};

/// How many such sets a primitive has; a mesh of characters has one, some have two.
std::size_t count_sets(const tinygltf::Primitive& primitive) {
  const auto has = [&](const char* name) { return primitive.attributes.contains(name); };
  if (!has("JOINTS_0") || !has("WEIGHTS_0")) return 0;
  return has("JOINTS_1") && has("WEIGHTS_1") ? 2 : 1;
}

Result<Influences> read_influences(const Build& build, const tinygltf::Primitive& primitive, std::size_t set) {
  const std::string number = std::to_string(set);
  Result<std::vector<float>> joints =
      read_floats(build.model, primitive.attributes.at("JOINTS_" + number), 4, kMaxMagnitude);
  if (!joints) return joints.error();
  Result<std::vector<float>> weights =
      read_floats(build.model, primitive.attributes.at("WEIGHTS_" + number), 4, kMaxMagnitude);
  if (!weights) return weights.error();
  return Influences{std::move(*joints), std::move(*weights)};
}

Result<std::vector<glm::dmat4>> nodes_to_world(const tinygltf::Model& model) {
  std::vector<glm::dmat4> to_world(model.nodes.size(), glm::dmat4(1));  // the parent's until the node is visited
  std::vector<int> stack = parentless_nodes(model);
  while (!stack.empty()) {
    const int at = stack.back();
    stack.pop_back();
    const Result<glm::dmat4> local = local_transform(model.nodes[at], place("nodes", static_cast<std::size_t>(at)));
    if (!local) return local.error();
    to_world[at] *= *local;
    for (int child : model.nodes[at].children) {
      to_world[child] = to_world[at];
      stack.push_back(child);
    }
  }
  return to_world;
}

/// The weighted mean of the joints of a vertex; the first joint where all weights are 0. Nothing where there is no such
/// joint.
std::optional<glm::dmat4> blend(const std::vector<Influences>& sets, std::size_t vertex,
                                const std::vector<glm::dmat4>& joints) {
  glm::dmat4 sum(0);
  double total = 0;
  for (const Influences& set : sets) {
    for (std::size_t i = 4 * vertex; i < 4 * vertex + 4; ++i) {
      if (set.weights[i] == 0) continue;
      if (!(set.joints[i] >= 0 && set.joints[i] < static_cast<float>(joints.size()))) return std::nullopt;
      sum += static_cast<double>(set.weights[i]) * joints[static_cast<std::size_t>(set.joints[i])];
      total += static_cast<double>(set.weights[i]);
    }
  }
  return total > 0 ? sum / total : joints[0];
}

/// Zero where there is no direction; that is repaired as if the file had it so.
Vec3 unit_or_zero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0 && std::isfinite(length) ? Vec3(v / length) : Vec3(0);
}

/// The inverse transpose by cofactors, up to a positive scale.
glm::dvec3 move_normal(const glm::dmat3& m, const Vec3& n) {
  const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
  const glm::dvec3 moved = cofactors * glm::dvec3(n);
  return glm::dot(m[0], cofactors[0]) < 0 ? -moved : moved;
}

/// Moves one vertex with its normal and tangent. False where it comes to lie absurdly far.
bool move_vertex(Mesh& mesh, std::size_t vertex, const glm::dmat4& to_world) {
  const glm::dmat3 linear(to_world);
  Vec3& position = mesh.positions[vertex];
  position = Vec3(glm::dvec3(to_world * glm::dvec4(position, 1)));
  if (!mesh.normals.empty()) mesh.normals[vertex] = unit_or_zero(move_normal(linear, mesh.normals[vertex]));
  if (!mesh.tangents.empty()) {
    Vec4& tangent = mesh.tangents[vertex];
    tangent = Vec4(unit_or_zero(linear * glm::dvec3(tangent)), tangent.w);
  }
  return max_component(glm::abs(position)) <= kMaxMagnitude && is_finite(position);
}

}  // namespace

bool is_skinned(const tinygltf::Model& model, const tinygltf::Node& node) {
  return node.skin >= 0 && std::ranges::all_of(model.meshes[node.mesh].primitives, count_sets);
}

Result<std::vector<glm::dmat4>> build_joints(Build& build, int index) {
  const tinygltf::Skin& skin = build.model.skins[index];
  const std::size_t matrices = skin.inverseBindMatrices < 0 ? 0 : build.model.accessors[skin.inverseBindMatrices].count;
  build.vertices += 4 * std::max(skin.joints.size(), matrices);  // a matrix is read like four of them
  if (build.vertices > build.limits.max_vertices) {
    return Error{ErrorCode::limit_exceeded, "the file has too many vertices and joints",
                 place("skins", static_cast<std::size_t>(index))};
  }
  if (build.nodes_to_world.empty()) {
    Result<std::vector<glm::dmat4>> nodes = nodes_to_world(build.model);
    if (!nodes) return nodes.error();
    build.nodes_to_world = std::move(*nodes);
  }
  std::vector<glm::dmat4> joints;
  for (int joint : skin.joints) joints.push_back(build.nodes_to_world[joint]);
  if (skin.inverseBindMatrices < 0) return joints;
  const Result<std::vector<float>> inverse_bind = read_floats(build.model, skin.inverseBindMatrices, 16, kMaxMagnitude);
  if (!inverse_bind) return inverse_bind.error();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    glm::dmat4 to_joint;
    for (int i = 0; i < 16; ++i) to_joint[i / 4][i % 4] = (*inverse_bind)[16 * j + static_cast<std::size_t>(i)];
    joints[j] *= to_joint;
  }
  return joints;
}

Status apply_skin(Mesh& mesh, const Build& build, const tinygltf::Primitive& primitive,
                  const std::vector<glm::dmat4>& joints, const std::string& where) {
  std::vector<Influences> sets;
  for (std::size_t set = 0; set < count_sets(primitive); ++set) {
    Result<Influences> influences = read_influences(build, primitive, set);
    if (!influences) return influences.error();
    sets.push_back(std::move(*influences));
  }
  for (std::size_t vertex = 0; vertex < mesh.positions.size(); ++vertex) {
    const std::optional<glm::dmat4> to_world = blend(sets, vertex, joints);
    if (!to_world) {
      return invalid_input("a vertex follows a joint that the skin does not have", where + ".attributes.JOINTS_0");
    }
    if (!move_vertex(mesh, vertex, *to_world)) return invalid_input("the skin moves a vertex absurdly far", where);
  }
  return Done{};
}

}  // namespace photond::gltf
