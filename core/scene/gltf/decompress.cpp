#include "core/scene/gltf/decompress.h"

namespace photond::gltf {

Error too_much_compressed_data(const std::string& where) {
  return {ErrorCode::limit_exceeded, "the file has too much compressed data", where};
}

Status DecompressionBudget::take(std::uint64_t taken, const std::string& where) {
  if (taken > bytes) return too_much_compressed_data(where);
  bytes -= taken;
  return Done{};
}

int add_view(tinygltf::Model& model, std::vector<unsigned char> bytes, std::size_t stride) {
  tinygltf::BufferView view;
  view.buffer = static_cast<int>(model.buffers.size());
  view.byteLength = bytes.size();
  view.byteStride = stride;
  model.buffers.emplace_back().data = std::move(bytes);
  model.bufferViews.push_back(std::move(view));
  return static_cast<int>(model.bufferViews.size()) - 1;
}

}  // namespace photond::gltf
