// KHR_draco_mesh_compression.
#include <cmath>
#include <cstring>
#include <type_traits>

#include "core/scene/gltf/accessor.h"
#include "core/scene/gltf/build.h"
#include "core/scene/gltf/check.h"
#include "core/scene/gltf/decompress.h"
#include "core/scene/gltf/draco_mesh.h"
#include "core/scene/gltf/value.h"

namespace photond::gltf {
namespace {

/// The components of all points of an attribute, each point `stride` bytes behind the other. False where a value does
/// not fit the type, or is no usable number.
template <class T>
bool copy_values(const draco::PointAttribute& attribute, std::size_t points, std::size_t stride, unsigned char* to) {
  std::vector<T> value(attribute.num_components());
  for (std::size_t i = 0; i < points; ++i, to += stride) {
    const draco::AttributeValueIndex at = attribute.mapped_index(draco::PointIndex(static_cast<std::uint32_t>(i)));
    if (at.value() >= attribute.size() || !attribute.ConvertValue<T>(at, value.data())) return false;
    for (const T component : value) {
      if (std::is_floating_point_v<T> && !(std::abs(static_cast<float>(component)) <= kMaxMagnitude)) return false;
    }
    std::memcpy(to, value.data(), value.size() * sizeof(T));
  }
  return true;
}

bool copy_values(const draco::PointAttribute& attribute, int component_type, std::size_t points, std::size_t stride,
                 unsigned char* to) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return copy_values<std::int8_t>(attribute, points, stride, to);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return copy_values<std::uint8_t>(attribute, points, stride, to);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return copy_values<std::int16_t>(attribute, points, stride, to);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return copy_values<std::uint16_t>(attribute, points, stride, to);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return copy_values<std::uint32_t>(attribute, points, stride, to);
    default:
      return copy_values<float>(attribute, points, stride, to);
  }
}

bool is_float(const draco::PointAttribute& attribute) {
  return attribute.data_type() == draco::DT_FLOAT32 || attribute.data_type() == draco::DT_FLOAT64;
}

/// Adds the accessor of one attribute, like the one that the file has for it, but with data.
Result<int> add_attribute(tinygltf::Model& model, int declared, const draco::PointAttribute& attribute,
                          std::size_t points, DecompressionBudget& budget, const std::string& where) {
  tinygltf::Accessor accessor = model.accessors[declared];
  const bool is_float_accessor = accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT;
  if (accessor.count != points || component_count(accessor.type) != attribute.num_components() ||
      (is_float(attribute) && !is_float_accessor)) {
    return invalid_input("accessor does not match the compressed data", where);
  }
  const std::size_t stride = (element_size(accessor) + 3) / 4 * 4;
  if (Status s = budget.take(points * stride, where); !s) return s.error();
  std::vector<unsigned char> bytes(points * stride);
  if (!copy_values(attribute, accessor.componentType, points, stride, bytes.data())) {
    return invalid_input("compressed data holds a value that is not finite or does not fit the accessor", where);
  }
  accessor.bufferView = add_view(model, std::move(bytes), stride);
  accessor.byteOffset = 0;
  accessor.sparse = {};
  model.accessors.push_back(std::move(accessor));
  return static_cast<int>(model.accessors.size()) - 1;
}

Status add_attributes(tinygltf::Model& model, tinygltf::Primitive& primitive, const tinygltf::Value& ids,
                      const draco::Mesh& mesh, DecompressionBudget& budget, const std::string& where) {
  for (const std::string& name : ids.Keys()) {
    const std::string at = where + ".attributes." + name.substr(0, 40);
    int& accessor = primitive.attributes.at(name);
    const auto* attribute = mesh.GetAttributeByUniqueId(static_cast<std::uint32_t>(number(&ids, name.c_str(), 0)));
    if (!attribute) return invalid_input("compressed data has no such attribute", at);
    const Result<int> added = add_attribute(model, accessor, *attribute, mesh.num_points(), budget, at);
    if (!added) return added.error();
    accessor = *added;
  }
  return Done{};
}

Status add_indices(tinygltf::Model& model, tinygltf::Primitive& primitive, const draco::Mesh& mesh,
                   DecompressionBudget& budget, const std::string& where) {
  const std::size_t count = 3 * static_cast<std::size_t>(mesh.num_faces());
  if (count == 0) return invalid_input("compressed data has no triangles", where);
  if (Status s = budget.take(count * sizeof(std::uint32_t), where); !s) return s;
  std::vector<unsigned char> bytes(count * sizeof(std::uint32_t));
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t point = mesh.face(draco::FaceIndex(static_cast<std::uint32_t>(i / 3)))[i % 3].value();
    std::memcpy(&bytes[i * sizeof point], &point, sizeof point);
  }
  tinygltf::Accessor accessor;
  accessor.bufferView = add_view(model, std::move(bytes), 0);
  accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  accessor.type = TINYGLTF_TYPE_SCALAR;
  accessor.count = count;
  model.accessors.push_back(std::move(accessor));
  primitive.indices = static_cast<int>(model.accessors.size()) - 1;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  return Done{};
}

/// What the extension names, before anything is added to the model.
Status check_compression(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                         const tinygltf::Value& draco, const std::string& where) {
  if (primitive.mode != TINYGLTF_MODE_TRIANGLES && primitive.mode != TINYGLTF_MODE_TRIANGLE_STRIP) {
    return invalid_input("only triangle lists and strips can be compressed", where);
  }
  const int view = static_cast<int>(number(&draco, "bufferView", -1));
  if (Status s = check_index(view, model.bufferViews.size(), where + ".bufferView"); !s) return s;
  const int indices = static_cast<int>(number(&draco, "indices", -1));
  if (Status s = check_index(indices, model.accessors.size(), where, true); !s) return s;
  for (const std::string& name : draco.Get("attributes").Keys()) {
    if (primitive.attributes.contains(name)) continue;
    return invalid_input("the primitive has no such attribute", where + ".attributes." + name.substr(0, 40));
  }
  return Done{};
}

Status decompress(tinygltf::Model& model, tinygltf::Primitive& primitive, const tinygltf::Value& draco,
                  DecompressionBudget& budget, const std::string& where) {
  const tinygltf::BufferView& view = model.bufferViews[static_cast<int>(number(&draco, "bufferView", -1))];
  if (Status s = budget.take(view.byteLength, where); !s) return s;
  const std::span<const unsigned char> buffer = model.buffers[view.buffer].data;
  const auto mesh = decode_draco_mesh(buffer.subspan(view.byteOffset, view.byteLength), budget.bytes, where);
  if (!mesh) return mesh.error();
  const int indices = static_cast<int>(number(&draco, "indices", -1));
  const std::size_t corners = 3 * static_cast<std::size_t>((*mesh)->num_faces());
  if (indices >= 0 && primitive.mode == TINYGLTF_MODE_TRIANGLES && model.accessors[indices].count != corners) {
    return invalid_input("the accessor of the indices does not match the compressed data", where);
  }
  if (Status s = add_indices(model, primitive, **mesh, budget, where); !s) return s;
  return add_attributes(model, primitive, draco.Get("attributes"), **mesh, budget, where);
}

/// Calls `act(primitive, extension, place of the extension)` for all compressed primitives until one fails.
template <class Act>
Status for_each_compressed(tinygltf::Model& model, const Act& act) {
  constexpr const char* kDraco = "KHR_draco_mesh_compression";
  for (std::size_t m = 0; m < model.meshes.size(); ++m) {
    for (std::size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
      tinygltf::Primitive& primitive = model.meshes[m].primitives[p];
      const tinygltf::Value* draco = extension(primitive.extensions, kDraco);
      if (!draco) continue;
      const std::string where = place("meshes", m) + "." + place("primitives", p) + ".extensions." + kDraco;
      if (Status s = act(primitive, *draco, where); !s) return s;
    }
  }
  return Done{};
}

}  // namespace

Status decompress_primitives(tinygltf::Model& model, DecompressionBudget& budget) {
  const auto check = [&](const tinygltf::Primitive& primitive, const tinygltf::Value& draco, const std::string& where) {
    return check_compression(model, primitive, draco, where);
  };
  if (Status s = for_each_compressed(model, check); !s) return s;
  return for_each_compressed(
      model, [&](tinygltf::Primitive& primitive, const tinygltf::Value& draco, const std::string& where) {
        return decompress(model, primitive, draco, budget, where);
      });
}

}  // namespace photond::gltf
