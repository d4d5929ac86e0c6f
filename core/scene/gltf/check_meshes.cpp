#include <map>
#include <string_view>
#include <utility>

#include "core/scene/gltf/accessor.h"
#include "core/scene/gltf/check.h"

namespace photond::gltf {
namespace {

constexpr int kFloat = TINYGLTF_COMPONENT_TYPE_FLOAT;
constexpr int kUnsignedInt = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;

bool is_unsigned(int type) {
  return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         type == kUnsignedInt;
}

/// Whether an attribute may have this type, KHR_mesh_quantization included.
bool attribute_type_allowed(std::string_view name, const tinygltf::Accessor& accessor) {
  const int type = accessor.type, component = accessor.componentType;
  if (component == kUnsignedInt) return false;
  if (name == "POSITION") return type == TINYGLTF_TYPE_VEC3;
  const bool signed_unit = component == kFloat || (!is_unsigned(component) && accessor.normalized);
  if (name == "NORMAL") return type == TINYGLTF_TYPE_VEC3 && signed_unit;
  if (name == "TANGENT") return type == TINYGLTF_TYPE_VEC4 && signed_unit;
  if (name.starts_with("TEXCOORD_")) return type == TINYGLTF_TYPE_VEC2;
  if (name.starts_with("COLOR_")) {
    return (type == TINYGLTF_TYPE_VEC3 || type == TINYGLTF_TYPE_VEC4) &&
           (component == kFloat || (is_unsigned(component) && accessor.normalized));
  }
  return (!name.starts_with("JOINTS_") && !name.starts_with("WEIGHTS_")) || type == TINYGLTF_TYPE_VEC4;
}

/// Sizes of elements by the view without byteStride and the place in it where they begin.
using PackedElements = std::map<std::pair<int, std::size_t>, std::size_t>;

/// Vertex data is aligned to 4 bytes, and says its stride where several attributes share a view.
Status check_layout(const tinygltf::Model& model, int accessor_index, PackedElements& packed,
                    const std::string& where) {
  const tinygltf::Accessor& accessor = model.accessors[accessor_index];
  if (accessor.bufferView < 0) return Done{};
  const std::size_t stride = model.bufferViews[accessor.bufferView].byteStride;
  const std::size_t effective = stride != 0 ? stride : element_size(accessor);
  if (accessor.byteOffset % 4 != 0 || (accessor.count > 1 && effective % 4 != 0)) {
    return invalid_input("vertex attribute is not aligned to 4 bytes", where);
  }
  if (stride != 0) return Done{};
  const auto [found, first] = packed.try_emplace({accessor.bufferView, accessor.byteOffset}, element_size(accessor));
  if (!first && found->second != element_size(accessor)) {
    return invalid_input("attributes share a buffer view without byteStride", where);
  }
  return Done{};
}

Status check_attributes(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                        const std::string& where) {
  for (const auto& [name, index] : primitive.attributes) {
    const std::string attribute_where = where + ".attributes." + name.substr(0, 40);
    if (Status s = check_index(index, model.accessors.size(), attribute_where); !s) return s;
  }
  const auto position = primitive.attributes.find("POSITION");
  PackedElements packed;
  for (const auto& [name, index] : primitive.attributes) {
    const std::string attribute_where = where + ".attributes." + name.substr(0, 40);
    const tinygltf::Accessor& accessor = model.accessors[index];
    if (!attribute_type_allowed(name, accessor)) {
      return invalid_input("accessor type is not allowed for this attribute", attribute_where);
    }
    if (position != primitive.attributes.end() && accessor.count != model.accessors[position->second].count) {
      return invalid_input("attributes have different counts", attribute_where);
    }
    if (Status s = check_layout(model, index, packed, attribute_where); !s) return s;
  }
  return Done{};
}

Status check_indices(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                     const std::string& where) {
  if (primitive.indices < 0) return Done{};
  if (Status s = check_index(primitive.indices, model.accessors.size(), where); !s) return s;
  const tinygltf::Accessor& accessor = model.accessors[primitive.indices];
  if (accessor.type != TINYGLTF_TYPE_SCALAR || !is_unsigned(accessor.componentType) || accessor.normalized) {
    return invalid_input("indices must be unsigned integer scalars", where);
  }
  if (accessor.bufferView >= 0 && model.bufferViews[accessor.bufferView].byteStride != 0) {
    return invalid_input("the buffer view of indices must not have a byteStride", where);
  }
  return Done{};
}

Status check_targets(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                     const std::string& where) {
  for (std::size_t t = 0; t < primitive.targets.size(); ++t) {
    for (const auto& [name, index] : primitive.targets[t]) {
      const std::string target_where = where + "." + place("targets", t) + "." + name.substr(0, 40);
      if (Status s = check_index(index, model.accessors.size(), target_where); !s) return s;
      const auto base = primitive.attributes.find(name);
      if (base == primitive.attributes.end()) continue;
      if (model.accessors[index].count != model.accessors[base->second].count) {
        return invalid_input("morph target and attribute have different counts", target_where);
      }
    }
  }
  return Done{};
}

Status check_primitive(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                       const std::string& where) {
  if (primitive.mode < TINYGLTF_MODE_POINTS || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
    return invalid_input("mode is not one of glTF", where + ".mode");
  }
  if (Status s = check_index(primitive.material, model.materials.size(), where + ".material", true); !s)
    return s;
  if (Status s = check_attributes(model, primitive, where); !s) return s;
  if (Status s = check_indices(model, primitive, where + ".indices"); !s) return s;
  return check_targets(model, primitive, where);
}

}  // namespace

Status check_meshes(const tinygltf::Model& model) {
  for (std::size_t m = 0; m < model.meshes.size(); ++m) {
    const tinygltf::Mesh& mesh = model.meshes[m];
    for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
      const std::string where = place("meshes", m) + "." + place("primitives", p);
      if (Status s = check_primitive(model, mesh.primitives[p], where); !s) return s;
      if (!mesh.weights.empty() && mesh.weights.size() != mesh.primitives[p].targets.size()) {
        return invalid_input("there must be one weight per morph target", place("meshes", m) + ".weights");
      }
    }
  }
  return Done{};
}

}  // namespace photond::gltf
