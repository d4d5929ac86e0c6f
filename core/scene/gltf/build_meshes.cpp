#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "core/scene/gltf/accessor.h"
#include "core/scene/gltf/build.h"
#include "core/scene/gltf/check.h"
#include "core/scene/gltf/triangles.h"

namespace photond::gltf {
namespace {

/// values += weight · target, for the components that the target has (a tangent's handedness is not morphed).
Status add_target(std::vector<float>& values, const Build& build, int target, double weight,
                  std::size_t width) {
  const std::size_t morphed = std::min(width, component_count(build.model.accessors[target].type));
  const Result<std::vector<float>> delta = read_floats(build.model, target, morphed, kMaxMagnitude);
  if (!delta) return delta.error();
  for (std::size_t i = 0; i < delta->size(); ++i) {
    float& value = values[i / morphed * width + i % morphed];
    value += static_cast<float>(weight) * (*delta)[i];
    if (!(std::abs(value) <= kMaxMagnitude)) {
      return invalid_input("morphed value is absurdly large",
                           place("accessors", static_cast<std::size_t>(target)));
    }
  }
  return Done{};
}

/// One attribute of a primitive with its morph targets added in.
Result<std::vector<float>> read_attribute(const Build& build, const tinygltf::Primitive& primitive,
                                          const std::vector<double>& weights, const std::string& name,
                                          std::size_t width) {
  const auto found = primitive.attributes.find(name);
  if (found == primitive.attributes.end()) return std::vector<float>{};
  Result<std::vector<float>> values = read_floats(build.model, found->second, width, kMaxMagnitude);
  if (!values) return values.error();
  for (std::size_t t = 0; t < std::min(weights.size(), primitive.targets.size()); ++t) {
    const auto target = primitive.targets[t].find(name);
    if (target == primitive.targets[t].end() || weights[t] == 0) continue;
    if (Status s = add_target(*values, build, target->second, weights[t], width); !s) return s.error();
  }
  return values;
}

template <class V>
Status read_into(std::vector<V>& out, const Build& build, const tinygltf::Primitive& primitive,
                 const std::vector<double>& weights, const std::string& name) {
  static_assert(sizeof(V) % sizeof(float) == 0);
  const Result<std::vector<float>> values =
      read_attribute(build, primitive, weights, name, sizeof(V) / sizeof(float));
  if (!values) return values.error();
  out.resize(values->size() * sizeof(float) / sizeof(V));
  if (!out.empty()) std::memcpy(out.data(), values->data(), values->size() * sizeof(float));
  return Done{};
}

Status read_attributes(Mesh& mesh, const Build& build, const tinygltf::Primitive& primitive,
                       const std::vector<double>& weights) {
  if (Status s = read_into(mesh.positions, build, primitive, weights, "POSITION"); !s) return s;
  if (Status s = read_into(mesh.normals, build, primitive, weights, "NORMAL"); !s) return s;
  if (Status s = read_into(mesh.tangents, build, primitive, weights, "TANGENT"); !s) return s;
  if (Status s = read_into(mesh.uv[0], build, primitive, weights, "TEXCOORD_0"); !s) return s;
  if (Status s = read_into(mesh.uv[1], build, primitive, weights, "TEXCOORD_1"); !s) return s;
  if (Status s = read_into(mesh.colors, build, primitive, weights, "COLOR_0"); !s) return s;
  return Done{};
}

/// As glTF demands. Returns whether that changes anything.
bool clamp_colors(Mesh& mesh) {
  bool changes = false;
  for (Vec4& color : mesh.colors) {
    const Vec4 clamped = glm::clamp(color, 0.0f, 1.0f);
    changes |= clamped != color;
    color = clamped;
  }
  return changes;
}

Error too_large(const char* what, const std::string& where) {
  return {ErrorCode::limit_exceeded, std::string("the file has too many ") + what, where};
}

/// Counts against the limits before anything is read: every morph target that is added in as the vertices themselves.
Status account(Build& build, const tinygltf::Primitive& primitive, std::size_t vertices,
               const std::vector<double>& weights, const std::string& where) {
  const std::size_t corners =
      primitive.indices >= 0 ? build.model.accessors[primitive.indices].count : vertices;
  const std::size_t unused = static_cast<std::size_t>(std::ranges::count(weights, 0.0));
  build.vertices += vertices * (1 + std::min(weights.size() - unused, primitive.targets.size()));
  build.triangles += primitive.mode == TINYGLTF_MODE_TRIANGLES ? corners / 3 : corners;
  if (build.vertices > build.limits.max_vertices) return too_large("vertices", where);
  if (build.triangles > build.limits.max_triangles) return too_large("triangles", where);
  return Done{};
}

/// The material's index in the scene; primitives without one share glTF's default material.
std::uint32_t material_index(Build& build, int material) {
  if (material >= 0) return static_cast<std::uint32_t>(material);
  if (build.default_material < 0) {
    build.default_material = static_cast<std::int64_t>(build.scene.materials.size());
    build.scene.materials.push_back(Material{.name = "default"});
  }
  return static_cast<std::uint32_t>(build.default_material);
}

void warn_of_missing_uv(Build& build, const Mesh& mesh, const std::string& where) {
  const Material& m = build.scene.materials[mesh.material];
  for (const TextureSlot* slot : texture_slots(m)) {
    if (slot->used() && mesh.uv[slot->uv_set].empty()) {
      return build.warnings.add("the material's textures need a TEXCOORD set that is missing", where);
    }
  }
  const TextureSlot& slot = m.normal_texture.used() ? m.normal_texture : m.anisotropy_texture;
  if (m.anisotropy > 0 && mesh.tangents.empty() && mesh.uv[slot.uv_set].empty()) {
    build.warnings.add("the material's anisotropy needs TANGENT or TEXCOORD, which are missing", where);
  }
}

/// The triangles of one primitive; nothing where it has none. `joints`: of its skin, empty where it has none.
Result<std::optional<Mesh>> build_primitive(Build& build, const tinygltf::Primitive& primitive,
                                            const std::vector<double>& weights,
                                            const std::vector<glm::dmat4>& joints, const std::string& where) {
  const auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end() || primitive.mode < TINYGLTF_MODE_TRIANGLES) {
    build.warnings.add("points, lines and primitives without positions are not shown", where);
    return std::optional<Mesh>();
  }
  const std::size_t vertices = build.model.accessors[position->second].count;
  if (Status s = account(build, primitive, vertices, weights, where); !s) return s.error();
  Mesh mesh;
  if (Status s = read_attributes(mesh, build, primitive, weights); !s) return s.error();
  if (!joints.empty()) {
    if (Status s = apply_skin(mesh, build, primitive, joints, where); !s) return s.error();
  }
  if (clamp_colors(mesh)) build.warnings.add("COLOR_0 is cut to between 0 and 1", where);
  Result<std::vector<glm::uvec3>> triangles = read_triangles(build.model, primitive, vertices, where);
  if (!triangles) return triangles.error();
  mesh.triangles = std::move(*triangles);
  if (const std::size_t dropped = drop_degenerate(mesh)) {
    if (build.degenerate == 0) build.first_degenerate = where;
    build.degenerate += dropped;
  }
  if (mesh.triangles.empty()) return std::optional<Mesh>();
  repair_normals(mesh);
  // [glTF 2.0, 3.7.2.1] Where there are no normals, tangents count for nothing.
  if (mesh.normals.empty()) mesh.tangents.clear();
  if (!normalize_tangents(mesh)) build.warnings.add("unusable tangents are derived from uv instead", where);
  mesh.material = material_index(build, primitive.material);
  warn_of_missing_uv(build, mesh, where);
  return std::optional<Mesh>(std::move(mesh));
}

}  // namespace

Result<std::vector<std::uint32_t>> build_mesh(Build& build, const tinygltf::Node& node) {
  const auto index = static_cast<std::size_t>(node.mesh);
  const tinygltf::Mesh& from = build.model.meshes[index];
  const std::vector<double>& weights = node.weights.empty() ? from.weights : node.weights;
  const int skin = is_skinned(build.model, node) ? node.skin : -1;
  const auto [found, inserted] = build.meshes.try_emplace({node.mesh, skin, weights});
  if (!inserted) return found->second;
  for (double weight : weights) {
    if (!(std::abs(weight) <= kMaxMagnitude)) {
      return invalid_input("morph weight is absurdly large", place("meshes", index));
    }
  }
  Result<std::vector<glm::dmat4>> joints = std::vector<glm::dmat4>{};
  if (skin >= 0) joints = build_joints(build, skin);
  if (!joints) return joints.error();
  for (std::size_t p = 0; p < from.primitives.size(); ++p) {
    const std::string where = place("meshes", index) + "." + place("primitives", p);
    Result<std::optional<Mesh>> mesh = build_primitive(build, from.primitives[p], weights, *joints, where);
    if (!mesh) return mesh.error();
    if (!mesh->has_value()) continue;
    (*mesh)->name = from.name;
    found->second.push_back(static_cast<std::uint32_t>(build.scene.meshes.size()));
    build.scene.meshes.push_back(std::move(**mesh));
  }
  return found->second;
}

}  // namespace photond::gltf
