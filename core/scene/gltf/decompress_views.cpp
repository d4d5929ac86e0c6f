// EXT_meshopt_compression.
#include <meshoptimizer.h>

#include <span>

#include "core/scene/gltf/check.h"
#include "core/scene/gltf/decompress.h"
#include "core/scene/gltf/value.h"

namespace photond::gltf {
namespace {

/// A buffer view's extension.
struct Packed {
  int buffer;
  std::size_t offset, length;  ///< of the compressed bytes
  std::size_t stride, count;   ///< of the elements that they hold
  std::string mode, filter;
};

Packed read_packed(const tinygltf::Value* extension) {
  const auto size = [&](const char* name) { return static_cast<std::size_t>(number(extension, name, 0)); };
  return {static_cast<int>(size("buffer")), size("byteOffset"),
          size("byteLength"),               size("byteStride"),
          size("count"),                    text(extension, "mode", {}),
          text(extension, "filter", "NONE")};
}

bool filter_allowed(const Packed& packed) {
  if (packed.filter == "NONE") return true;
  if (packed.mode != "ATTRIBUTES") return false;
  return packed.filter == "OCTAHEDRAL" || packed.filter == "QUATERNION" || packed.filter == "EXPONENTIAL";
}

bool stride_allowed(const Packed& packed) {
  if (packed.mode != "ATTRIBUTES") return packed.stride == 2 || packed.stride == 4;
  if (packed.filter == "OCTAHEDRAL") return packed.stride == 4 || packed.stride == 8;
  if (packed.filter == "QUATERNION") return packed.stride == 8;
  return packed.stride % 4 == 0 && packed.stride <= 256;
}

/// The least bytes that so many elements take: two bits for sixteen bytes that do not change from element to element,
/// one byte for a triangle or an index.
std::size_t least_length(const Packed& packed) {
  if (packed.mode == "ATTRIBUTES") return packed.count * packed.stride / 64;
  return packed.mode == "TRIANGLES" ? packed.count / 3 : packed.count;
}

/// The rules of the extension's specification.
Status check_packed(const Packed& packed, const tinygltf::BufferView& view, const std::string& where) {
  if (packed.mode != "ATTRIBUTES" && packed.mode != "TRIANGLES" && packed.mode != "INDICES") {
    return invalid_input("mode is not one of the extension", where + ".mode");
  }
  if (!filter_allowed(packed)) return invalid_input("filter is not allowed here", where + ".filter");
  if (!stride_allowed(packed) || (view.byteStride != 0 && view.byteStride != packed.stride)) {
    return invalid_input("byteStride is not allowed", where + ".byteStride");
  }
  if (packed.mode == "TRIANGLES" && packed.count % 3 != 0) {
    return invalid_input("count must be three per triangle", where + ".count");
  }
  if (view.byteLength != packed.stride * packed.count) {
    return invalid_input("elements do not fill the buffer view", where + ".count");
  }
  if (least_length(packed) > packed.length) return invalid_input("data holds fewer elements", where + ".count");
  return Done{};
}

/// Whether the view lies in its buffer as that is declared, whose data is not used.
Status check_place(const tinygltf::BufferView& view, const std::vector<BufferDeclaration>& declared,
                   const std::string& where) {
  const std::uint64_t size = declared[view.buffer].byte_length;
  if (view.byteOffset <= size && view.byteLength <= size - view.byteOffset) return Done{};
  return invalid_input("range exceeds the buffer", where);
}

void apply_filter(const Packed& packed, std::vector<unsigned char>& bytes) {
  if (packed.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(bytes.data(), packed.count, packed.stride);
  if (packed.filter == "QUATERNION") meshopt_decodeFilterQuat(bytes.data(), packed.count, packed.stride);
  if (packed.filter == "EXPONENTIAL") meshopt_decodeFilterExp(bytes.data(), packed.count, packed.stride);
}

/// Whether the data is that of its mode and holds just these elements.
bool decode(const Packed& packed, std::span<const unsigned char> data, unsigned char* out) {
  const std::size_t count = packed.count, stride = packed.stride;
  if (packed.mode == "ATTRIBUTES") {
    return meshopt_decodeVertexBuffer(out, count, stride, data.data(), data.size()) == 0;
  }
  if (packed.mode == "TRIANGLES") return meshopt_decodeIndexBuffer(out, count, stride, data.data(), data.size()) == 0;
  return meshopt_decodeIndexSequence(out, count, stride, data.data(), data.size()) == 0;
}

Status decompress(tinygltf::Model& model, std::size_t index, const std::vector<BufferDeclaration>& declared,
                  DecompressionBudget& budget) {
  tinygltf::BufferView& view = model.bufferViews[index];
  if (Status s = check_index(view.buffer, declared.size(), place("bufferViews", index) + ".buffer"); !s) return s;
  const tinygltf::Value* meshopt = extension(view.extensions, "EXT_meshopt_compression");
  if (!meshopt) return Done{};
  if (Status s = check_place(view, declared, place("bufferViews", index)); !s) return s;
  const std::string where = place("bufferViews", index) + ".extensions.EXT_meshopt_compression";
  const Packed packed = read_packed(meshopt);
  if (Status s = check_packed(packed, view, where); !s) return s;
  if (Status s = check_index(packed.buffer, declared.size(), where + ".buffer"); !s) return s;
  const std::span<const unsigned char> data = model.buffers[packed.buffer].data;
  if (packed.offset > data.size() || packed.length > data.size() - packed.offset) {
    return invalid_input("range exceeds the buffer", where);
  }
  if (Status s = budget.take(packed.length + packed.count * packed.stride, where); !s) return s;
  std::vector<unsigned char> bytes(packed.count * packed.stride);
  if (!decode(packed, data.subspan(packed.offset, packed.length), bytes.data())) {
    return invalid_input("data cannot be decompressed", where);
  }
  apply_filter(packed, bytes);
  view.buffer = static_cast<int>(model.buffers.size());
  view.byteOffset = 0;
  model.buffers.emplace_back().data = std::move(bytes);
  return Done{};
}

}  // namespace

Status decompress_views(tinygltf::Model& model, const std::vector<BufferDeclaration>& declared,
                        DecompressionBudget& budget) {
  for (std::size_t i = 0; i < model.bufferViews.size(); ++i) {
    if (Status s = decompress(model, i, declared, budget); !s) return s;
  }
  return Done{};
}

}  // namespace photond::gltf
