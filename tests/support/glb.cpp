#include "tests/support/glb.h"

namespace photond::test {
namespace {

using nlohmann::json;

void put_u32(std::string& out, std::size_t value) {
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<char>(value >> (8 * i) & 0xFF));
}

void put_chunk(std::string& out, std::string_view type, std::string data, char padding) {
  data.resize((data.size() + 3) / 4 * 4, padding);
  put_u32(out, data.size());
  out += type;
  out += data;
}

}  // namespace

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

std::vector<std::byte> make_glb(const json& document, const std::string& bin) {
  std::string chunks;
  put_chunk(chunks, "JSON", document.dump(), ' ');
  if (!bin.empty()) put_chunk(chunks, std::string_view("BIN\0", 4), bin, '\0');
  std::string out = "glTF";
  put_u32(out, 2);
  put_u32(out, 12 + chunks.size());
  return bytes_of(out + chunks);
}

GlbDraft::GlbDraft() {
  json = {{"asset", {{"version", "2.0"}}},
          {"scene", 0},
          {"scenes", json::array({{{"nodes", {0}}}})},
          {"nodes", json::array({{{"mesh", 0}}})},
          {"bufferViews", json::array()},
          {"accessors", json::array()}};
  const int positions = add_accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, 5126, "VEC3", 3);
  json["meshes"] = json::array({{{"primitives", json::array({{{"attributes", {{"POSITION", positions}}}}})}}});
}

std::vector<std::byte> GlbDraft::pack() const {
  nlohmann::json document = json;
  document["buffers"][0] = {{"byteLength", bin.size()}};
  return make_glb(document, bin);
}

}  // namespace photond::test
