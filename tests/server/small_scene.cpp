#include "tests/server/small_scene.h"

#include <cstdint>
#include <cstring>

namespace photond::test {

namespace {

/// `buffer` is what the buffer object holds beside its length.
std::string document(const std::string& name, const std::string& buffer) {
  return R"({"asset":{"version":"2.0","generator":")" + name + R"("},"scene":0,"scenes":[{"nodes":[0,1,2,3]}],
"nodes":[{"mesh":0,"scale":[2,1,2]},
{"mesh":1,"translation":[0,2,0],"rotation":[1,0,0,0],"scale":[0.5,1,0.5]},
{"camera":0,"name":"front","translation":[0,1,5]},
{"camera":1,"name":"above","translation":[0,6,0],"rotation":[-0.70710678,0,0,0.70710678]}],
"cameras":[{"type":"perspective","name":"front","perspective":{"yfov":0.8,"znear":0.1}},
{"type":"perspective","name":"above","perspective":{"yfov":0.6,"znear":0.1}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]},
{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":1}]}],
"materials":[{"name":"floor","pbrMetallicRoughness":{"baseColorFactor":[0.7,0.7,0.7,1],"metallicFactor":0}},
{"name":"lamp","emissiveFactor":[1,1,1],"pbrMetallicRoughness":{"baseColorFactor":[0,0,0,1],"metallicFactor":0}}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[-1,0,-1],"max":[1,0,1]},
{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],
"buffers":[{"byteLength":60)" +
         buffer + "}]}";
}

void append(std::string& text, std::uint32_t value) {
  char bytes[4];
  std::memcpy(bytes, &value, 4);
  text.append(bytes, 4);
}

}  // namespace

std::string quad_bin() {
  const float positions[12] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1};
  const std::uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
  std::string bytes(60, '\0');
  std::memcpy(bytes.data(), positions, 48);
  std::memcpy(bytes.data() + 48, indices, 12);
  return bytes;
}

std::string small_gltf() { return document("small", R"(,"uri":"quad.bin")"); }

std::string small_glb(const std::string& name) {
  std::string json = document(name, "");
  while (json.size() % 4 != 0) json += ' ';
  std::string glb = "glTF";
  append(glb, 2);
  append(glb, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + 60));
  append(glb, static_cast<std::uint32_t>(json.size()));
  glb += "JSON" + json;
  append(glb, 60);
  glb += std::string("BIN\0", 4) + quad_bin();
  return glb;
}

}  // namespace photond::test
