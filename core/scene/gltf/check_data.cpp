// Buffer views, accessors, images, samplers, textures.
#include "core/scene/gltf/accessor.h"
#include "core/scene/gltf/check.h"
#include "core/scene/gltf/value.h"

namespace photond::gltf {
namespace {

Status check_view(const tinygltf::Model& model, const tinygltf::BufferView& view, const std::string& where) {
  if (Status status = check_index(view.buffer, model.buffers.size(), where + ".buffer"); !status) return status;
  const std::size_t size = model.buffers[view.buffer].data.size();
  if (view.byteOffset > size || view.byteLength > size - view.byteOffset) {
    return invalid_input("range exceeds the buffer", where);
  }
  const std::size_t stride = view.byteStride;
  if (stride != 0 && (stride < 4 || stride > 252 || stride % 4 != 0 || stride > view.byteLength)) {
    return invalid_input("byteStride is not allowed", where + ".byteStride");
  }
  return Done{};
}

/// Whether `count` elements of `size` bytes, `stride` apart, lie inside a view and are aligned to `component`.
Status check_range(const tinygltf::BufferView& view, std::size_t offset, std::size_t count, std::size_t size,
                   std::size_t stride, std::size_t component, const std::string& where) {
  if (offset % component != 0 || (offset + view.byteOffset) % component != 0 || stride % component != 0) {
    return invalid_input("data is not aligned to its component type", where);
  }
  if (stride < size) return invalid_input("byteStride is smaller than an element", where);
  if (offset > view.byteLength || size > view.byteLength - offset ||
      (count - 1) > (view.byteLength - offset - size) / stride) {
    return invalid_input("data exceeds its buffer view", where);
  }
  return Done{};
}

Status check_sparse(const tinygltf::Model& model, const tinygltf::Accessor& accessor,
                    const std::string& where) {
  const auto& sparse = accessor.sparse;
  const int type = sparse.indices.componentType;
  if (sparse.count < 1 || static_cast<std::size_t>(sparse.count) > accessor.count) {
    return invalid_input("sparse count is larger than the accessor", where + ".sparse.count");
  }
  if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
      type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) {
    return invalid_input("sparse indices must be unsigned integers", where + ".sparse.indices");
  }
  const std::size_t views = model.bufferViews.size();
  const std::string indices = where + ".sparse.indices", values = where + ".sparse.values";
  if (Status s = check_index(sparse.indices.bufferView, views, indices + ".bufferView"); !s) return s;
  if (Status s = check_index(sparse.values.bufferView, views, values + ".bufferView"); !s) return s;
  const auto count = static_cast<std::size_t>(sparse.count);
  const std::size_t index_size = component_size(type);
  const std::size_t size = element_size(accessor);
  if (Status s = check_range(model.bufferViews[sparse.indices.bufferView], sparse.indices.byteOffset, count,
                             index_size, index_size, index_size, indices);
      !s) {
    return s;
  }
  return check_range(model.bufferViews[sparse.values.bufferView], sparse.values.byteOffset, count, size, size,
                     component_size(accessor.componentType), values);
}

Status check_accessor(const tinygltf::Model& model, const tinygltf::Accessor& accessor,
                      const std::string& where) {
  if (component_size(accessor.componentType) == 0) {
    return invalid_input("component type is not one of glTF", where + ".componentType");
  }
  const bool is_float_or_uint = accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT ||
                                accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  if (accessor.normalized && is_float_or_uint) {
    return invalid_input("float and uint data cannot be normalized", where + ".normalized");
  }
  if (accessor.bufferView < 0 && accessor.byteOffset != 0) {
    return invalid_input("byteOffset without a bufferView", where + ".byteOffset");
  }
  if (accessor.bufferView >= 0) {
    const std::string view_where = where + ".bufferView";
    if (Status s = check_index(accessor.bufferView, model.bufferViews.size(), view_where); !s) return s;
    const tinygltf::BufferView& view = model.bufferViews[accessor.bufferView];
    const std::size_t size = element_size(accessor);
    const std::size_t stride = view.byteStride != 0 ? view.byteStride : size;
    const std::size_t component = component_size(accessor.componentType);
    if (Status s = check_range(view, accessor.byteOffset, accessor.count, size, stride, component, where); !s) {
      return s;
    }
  }
  return accessor.sparse.isSparse ? check_sparse(model, accessor, where) : Status(Done{});
}

Status check_image(const tinygltf::Model& model, const tinygltf::Image& image, const std::string& where) {
  if (image.bufferView < 0) return Done{};
  if (Status s = check_index(image.bufferView, model.bufferViews.size(), where + ".bufferView"); !s) return s;
  if (image.mimeType.empty()) return invalid_input("mimeType is missing", where + ".mimeType");
  if (model.bufferViews[image.bufferView].byteStride != 0) {
    return invalid_input("the buffer view of an image must not have a byteStride", where + ".bufferView");
  }
  return Done{};
}

bool is_wrap(int mode) {
  return mode == TINYGLTF_TEXTURE_WRAP_REPEAT || mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE ||
         mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT;
}
bool is_filter(int filter) {
  return filter == -1 || filter == TINYGLTF_TEXTURE_FILTER_NEAREST || filter == TINYGLTF_TEXTURE_FILTER_LINEAR;
}

}  // namespace

Status check_buffer_views(const tinygltf::Model& model) {
  for (std::size_t i = 0; i < model.bufferViews.size(); ++i) {
    if (Status s = check_view(model, model.bufferViews[i], place("bufferViews", i)); !s) return s;
  }
  return Done{};
}

Status check_accessors(const tinygltf::Model& model, const SceneLimits& limits) {
  for (std::size_t i = 0; i < model.accessors.size(); ++i) {
    const std::string where = place("accessors", i);
    if (Status s = check_accessor(model, model.accessors[i], where); !s) return s;
    // Three indices per triangle are the most that a file within the other limits can use.
    if (model.accessors[i].count > std::max(limits.max_vertices, 3 * limits.max_triangles)) {
      return Error{ErrorCode::limit_exceeded, "accessor has too many elements", where + ".count"};
    }
  }
  return Done{};
}

Status check_textures(const tinygltf::Model& model) {
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    if (Status s = check_image(model, model.images[i], place("images", i)); !s) return s;
  }
  for (std::size_t i = 0; i < model.samplers.size(); ++i) {
    const tinygltf::Sampler& sampler = model.samplers[i];
    if (!is_wrap(sampler.wrapS) || !is_wrap(sampler.wrapT) || !is_filter(sampler.magFilter)) {
      return invalid_input("unknown wrap mode or filter", place("samplers", i));
    }
  }
  for (std::size_t i = 0; i < model.textures.size(); ++i) {
    const tinygltf::Texture& texture = model.textures[i];
    const std::string where = place("textures", i);
    if (Status s = check_index(texture.source, model.images.size(), where + ".source", true); !s) return s;
    if (Status s = check_index(texture.sampler, model.samplers.size(), where + ".sampler", true); !s) return s;
    const int webp = static_cast<int>(number(extension(texture.extensions, "EXT_texture_webp"), "source", -1));
    if (Status s = check_index(webp, model.images.size(), where + ".extensions.EXT_texture_webp.source", true);
        !s) {
      return s;
    }
  }
  return Done{};
}

}  // namespace photond::gltf
