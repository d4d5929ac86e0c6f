#include "core/scene/gltf/accessor.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/scene/gltf/check.h"

namespace photond::gltf {
namespace {

/// Where the elements of an accessor, or of its sparse part, lie in memory.
struct Elements {
  const unsigned char* first = nullptr;
  std::size_t stride = 0;
};

Elements view_elements(const tinygltf::Model& model, int view_index, std::size_t offset, std::size_t size) {
  const tinygltf::BufferView& view = model.bufferViews[view_index];
  return {model.buffers[view.buffer].data.data() + view.byteOffset + offset,
          view.byteStride != 0 ? view.byteStride : size};
}

template <class T>
T load(const unsigned char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

std::uint32_t load_unsigned(const unsigned char* at, int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return *at;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return load<std::uint16_t>(at);
    default:
      return load<std::uint32_t>(at);
  }
}

/// [glTF 2.0, 3.6.2.2 and "Animations": the normalized integer conversions]
float load_float(const unsigned char* at, int type, bool normalized) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: {
      const float value = load<std::int8_t>(at);
      return normalized ? std::max(value / 127.0f, -1.0f) : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: {
      const float value = *at;
      return normalized ? value / 255.0f : value;
    }
    case TINYGLTF_COMPONENT_TYPE_SHORT: {
      const float value = load<std::int16_t>(at);
      return normalized ? std::max(value / 32767.0f, -1.0f) : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: {
      const float value = load<std::uint16_t>(at);
      return normalized ? value / 65535.0f : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return static_cast<float>(load<std::uint32_t>(at));
    default:
      return load<float>(at);
  }
}

/// Calls `store(element, bytes)` for the elements of the accessor, then for those that its sparse part
/// replaces.
template <class Store>
Status for_each_element(const tinygltf::Model& model, int index, const Store& store) {
  const tinygltf::Accessor& accessor = model.accessors[index];
  const std::size_t size = element_size(accessor);
  if (accessor.bufferView >= 0) {
    const Elements from = view_elements(model, accessor.bufferView, accessor.byteOffset, size);
    for (std::size_t i = 0; i < accessor.count; ++i) store(i, from.first + i * from.stride);
  }
  if (!accessor.sparse.isSparse) return Done{};
  const auto& sparse = accessor.sparse;
  const std::size_t index_size = component_size(sparse.indices.componentType);
  const Elements at = view_elements(model, sparse.indices.bufferView, sparse.indices.byteOffset, index_size);
  const Elements from = view_elements(model, sparse.values.bufferView, sparse.values.byteOffset, size);
  std::uint64_t next_allowed = 0;
  for (int i = 0; i < sparse.count; ++i) {
    // Sparse data is tightly packed whatever the view's stride.
    const std::uint32_t target = load_unsigned(at.first + i * index_size, sparse.indices.componentType);
    if (target < next_allowed || target >= accessor.count) {
      return invalid_input("sparse indices must increase and stay inside the accessor",
                           place("accessors", index) + ".sparse.indices");
    }
    next_allowed = static_cast<std::uint64_t>(target) + 1;
    store(target, from.first + i * size);
  }
  return Done{};
}

}  // namespace

std::size_t component_size(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

std::size_t component_count(int type) {
  switch (type) {
    case TINYGLTF_TYPE_SCALAR:
      return 1;
    case TINYGLTF_TYPE_VEC2:
      return 2;
    case TINYGLTF_TYPE_VEC3:
      return 3;
    case TINYGLTF_TYPE_VEC4:
    case TINYGLTF_TYPE_MAT2:
      return 4;
    case TINYGLTF_TYPE_MAT3:
      return 9;
    default:
      return 16;
  }
}

std::size_t element_size(const tinygltf::Accessor& accessor) {
  const std::size_t component = component_size(accessor.componentType);
  const auto padded = [component](std::size_t n) { return n * ((n * component + 3) / 4 * 4); };
  switch (accessor.type) {
    case TINYGLTF_TYPE_MAT2:
      return padded(2);
    case TINYGLTF_TYPE_MAT3:
      return padded(3);
    case TINYGLTF_TYPE_MAT4:
      return padded(4);
    default:
      return component_count(accessor.type) * component;
  }
}

Result<std::vector<float>> read_floats(const tinygltf::Model& model, int index, std::size_t width,
                                       float max_magnitude) {
  const tinygltf::Accessor& accessor = model.accessors[index];
  const std::size_t present = std::min(width, component_count(accessor.type));
  const std::size_t component = component_size(accessor.componentType);
  std::vector<float> out(accessor.count * width, 0.0f);
  if (present < 4 && width == 4) {
    for (std::size_t i = 3; i < out.size(); i += 4) out[i] = 1.0f;
  }
  bool sound = true;
  const auto store = [&](std::size_t i, const unsigned char* bytes) {
    for (std::size_t c = 0; c < present; ++c) {
      const float value = load_float(bytes + c * component, accessor.componentType, accessor.normalized);
      sound = sound && std::abs(value) <= max_magnitude;  // false for NaN
      out[i * width + c] = value;
    }
  };
  if (Status status = for_each_element(model, index, store); !status) return status.error();
  if (!sound) {
    return invalid_input("contains a value that is not finite or absurdly large", place("accessors", index));
  }
  return out;
}

Result<std::vector<std::uint32_t>> read_indices(const tinygltf::Model& model, int index) {
  const tinygltf::Accessor& accessor = model.accessors[index];
  std::vector<std::uint32_t> out(accessor.count, 0);
  const auto store = [&](std::size_t i, const unsigned char* bytes) {
    out[i] = load_unsigned(bytes, accessor.componentType);
  };
  if (Status status = for_each_element(model, index, store); !status) return status.error();
  return out;
}

}  // namespace photond::gltf
