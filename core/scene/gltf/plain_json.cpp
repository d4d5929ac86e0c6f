#include "core/scene/gltf/plain_json.h"

#include <nlohmann/json.hpp>

namespace photond::gltf {
namespace {

using nlohmann::json;

void move_indices(json& primitive) {
  const auto extensions = primitive.find("extensions");
  if (extensions == primitive.end()) return;
  const auto draco = extensions->find("KHR_draco_mesh_compression");
  if (draco == extensions->end()) return;
  draco->erase("indices");
  if (!primitive.contains("indices")) return;
  (*draco)["indices"] = primitive["indices"];
  primitive.erase("indices");
}

}  // namespace

bool is_placeholder(const JsonScan& scan, std::size_t buffer, bool binary) {
  if (!scan.meshopt) return false;
  const bool is_bin_chunk = binary && buffer == 0;
  return scan.buffers[buffer].fallback || (scan.buffers[buffer].uri.empty() && !is_bin_chunk);
}

std::string plain_json(const Container& container, const JsonScan& scan) {
  json document = json::parse(container.json);
  for (std::size_t i = 0; i < scan.buffers.size(); ++i) {
    json& buffer = document["buffers"][i];
    if (is_placeholder(scan, i, container.binary)) {
      buffer = {{"byteLength", 1}, {"uri", "data:application/octet-stream;base64,AA=="}};
    } else if (scan.buffers[i].uri.empty()) {
      buffer["uri"] = "BIN";
    }
  }
  if (!document.contains("meshes")) return document.dump();
  for (json& mesh : document["meshes"]) {
    for (json& primitive : mesh["primitives"]) move_indices(primitive);
  }
  return document.dump();
}

}  // namespace photond::gltf
