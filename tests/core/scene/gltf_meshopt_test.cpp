// Buffer views under EXT_meshopt_compression.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <cmath>
#include <cstring>

#include "core/scene/gltf.h"
#include "tests/support/read_draft.h"

namespace photond {
namespace {

using nlohmann::json;
using test::GlbDraft;
using test::primitive;
using test::read;
using test::refusal;
using testing::HasSubstr;

constexpr int kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125, kByte = 5120, kFloat = 5126;
constexpr int kSide = 20;  // squares of the grid, so that there are several blocks of vertices

std::string encode_attributes(const void* data, std::size_t count, std::size_t stride) {
  std::string out(meshopt_encodeVertexBufferBound(count, stride), '\0');
  out.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(out.data()), out.size(), data, count, stride));
  return out;
}

std::string encode_triangles(const std::vector<std::uint32_t>& indices) {
  std::string out(meshopt_encodeIndexBufferBound(indices.size(), 1 << 16), '\0');
  out.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(out.data()), out.size(), indices.data(),
                                       indices.size()));
  return out;
}

std::string encode_indices(const std::vector<std::uint32_t>& indices) {
  std::string out(meshopt_encodeIndexSequenceBound(indices.size(), 1 << 16), '\0');
  out.resize(meshopt_encodeIndexSequence(reinterpret_cast<unsigned char*>(out.data()), out.size(), indices.data(),
                                         indices.size()));
  return out;
}

/// Adds compressed elements as buffer view and accessor and returns the accessor's index. The view lies in buffer 1,
/// which has no data.
int add_compressed(GlbDraft& draft, const std::string& data, std::size_t stride, const char* mode, const char* filter,
                   const json& accessor) {
  const std::size_t count = accessor["count"];
  const std::size_t offset = test::put(draft.bin, std::vector<char>(data.begin(), data.end()));
  const std::size_t place = draft.json.value("/buffers/1/byteLength"_json_pointer, std::size_t{0});
  json view = {{"buffer", 1}, {"byteOffset", place}, {"byteLength", count * stride}};
  if (std::string(mode) == "ATTRIBUTES") view["byteStride"] = stride;
  view["extensions"]["EXT_meshopt_compression"] = {
      {"buffer", 0},    {"byteOffset", offset}, {"byteLength", data.size()}, {"byteStride", stride},
      {"count", count}, {"mode", mode},         {"filter", filter}};
  draft.json["buffers"][1]["byteLength"] = place + (count * stride + 3) / 4 * 4;
  draft.json["bufferViews"].push_back(view);
  draft.json["accessors"].push_back(accessor);
  draft.json["accessors"].back()["bufferView"] = draft.json["bufferViews"].size() - 1;
  return static_cast<int>(draft.json["accessors"].size()) - 1;
}

std::vector<float> grid_positions() {
  std::vector<float> out;
  for (int y = 0; y <= kSide; ++y) {
    for (int x = 0; x <= kSide; ++x) {
      out.insert(out.end(), {static_cast<float>(x), static_cast<float>(y), std::sin(static_cast<float>(x * y))});
    }
  }
  return out;
}

std::vector<std::uint32_t> grid_triangles() {
  std::vector<std::uint32_t> out;
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const std::uint32_t a = y * (kSide + 1) + x, b = a + kSide + 1;
      for (const std::uint32_t corner : {a, a + 1, b, b, a + 1, b + 1}) out.push_back(corner);
    }
  }
  return out;
}

int add_positions(GlbDraft& draft) {
  const std::vector<float> positions = grid_positions();
  return add_compressed(draft, encode_attributes(positions.data(), positions.size() / 3, 12), 12, "ATTRIBUTES", "NONE",
                        {{"componentType", kFloat}, {"count", positions.size() / 3}, {"type", "VEC3"}});
}

/// The grid with positions and triangles compressed: buffer views 1 and 2.
GlbDraft compressed_grid(int index_type = kUnsignedShort) {
  GlbDraft draft;
  primitive(draft)["attributes"]["POSITION"] = add_positions(draft);
  const std::vector<std::uint32_t> triangles = grid_triangles();
  primitive(draft)["indices"] =
      add_compressed(draft, encode_triangles(triangles), index_type == kUnsignedShort ? 2 : 4, "TRIANGLES", "NONE",
                     {{"componentType", index_type}, {"count", triangles.size()}, {"type", "SCALAR"}});
  return draft;
}

/// The corners of all triangles, each triangle turned so that its least corner is first: the compression turns them.
std::vector<std::vector<float>> corners(const Scene& scene) {
  std::vector<std::vector<float>> out;
  for (const Mesh& mesh : scene.meshes) {
    for (const glm::uvec3& t : mesh.triangles) {
      std::vector<std::vector<float>> three;
      for (const std::uint32_t i : {t.x, t.y, t.z}) {
        three.push_back({mesh.positions[i].x, mesh.positions[i].y, mesh.positions[i].z});
      }
      std::rotate(three.begin(), std::min_element(three.begin(), three.end()), three.end());
      out.push_back(three[0]);
      for (int i = 1; i < 3; ++i) out.back().insert(out.back().end(), three[i].begin(), three[i].end());
    }
  }
  return out;
}

std::vector<std::vector<float>> corners_of_grid() {
  GlbDraft draft;
  primitive(draft)["attributes"]["POSITION"] = draft.add_accessor(grid_positions(), kFloat, "VEC3", 3);
  primitive(draft)["indices"] = draft.add_accessor(grid_triangles(), kUnsignedInt, "SCALAR", 1);
  return corners(read(draft));
}

TEST(GltfMeshopt, ReadsAttributesAndTriangles) {
  EXPECT_EQ(corners(read(compressed_grid(kUnsignedShort))), corners_of_grid());
  EXPECT_EQ(corners(read(compressed_grid(kUnsignedInt))), corners_of_grid());
  GlbDraft draft = compressed_grid();
  draft.json["extensionsUsed"] = draft.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  EXPECT_EQ(read(draft).meshes.size(), 1u);
}

TEST(GltfMeshopt, ReadsIndicesOfAnyTopology) {
  for (const int type : {kUnsignedShort, kUnsignedInt}) {
    GlbDraft draft;
    primitive(draft)["attributes"]["POSITION"] = add_positions(draft);
    primitive(draft)["mode"] = 5;
    primitive(draft)["indices"] =
        add_compressed(draft, encode_indices({0, 21, 1, 400}), type == kUnsignedShort ? 2 : 4, "INDICES", "NONE",
                       {{"componentType", type}, {"count", 4}, {"type", "SCALAR"}});
    const Scene scene = read(draft);
    ASSERT_EQ(scene.meshes.size(), 1u);
    const std::vector<glm::uvec3> expected = {{0, 21, 1}, {21, 400, 1}};
    EXPECT_EQ(scene.meshes[0].triangles, expected);
  }
}

TEST(GltfMeshopt, ReadsSparseAccessors) {
  GlbDraft draft;
  const std::string indices = encode_indices({0, 2});
  const std::vector<float> values = {0, 0, 7, 0, 1, 8};
  const int at = add_compressed(draft, indices, 2, "INDICES", "NONE",
                                {{"componentType", kUnsignedShort}, {"count", 2}, {"type", "SCALAR"}});
  const int to = add_compressed(draft, encode_attributes(values.data(), 2, 12), 12, "ATTRIBUTES", "NONE",
                                {{"componentType", kFloat}, {"count", 2}, {"type", "VEC3"}});
  const json& accessors = draft.json["accessors"];
  draft.json["accessors"][0]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", accessors[at]["bufferView"]}, {"componentType", kUnsignedShort}}},
      {"values", {{"bufferView", accessors[to]["bufferView"]}}}};
  const Scene scene = read(draft);
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.meshes[0].positions[0], Vec3(0, 0, 7));
  EXPECT_EQ(scene.meshes[0].positions[1], Vec3(1, 0, 0));
  EXPECT_EQ(scene.meshes[0].positions[2], Vec3(0, 1, 8));
}

TEST(GltfMeshopt, AppliesTheOctahedralFilter) {
  const std::vector<float> normals = {0.6f, 0, 0.8f, 0, -0.36f, 0.48f, -0.8f, 0, 0, -1, 0, 0};
  for (const std::size_t stride : {4, 8}) {
    GlbDraft draft;
    std::vector<char> filtered(3 * stride);
    meshopt_encodeFilterOct(filtered.data(), 3, stride, stride == 4 ? 8 : 12, normals.data());
    const int type = stride == 4 ? kByte : kShort;
    primitive(draft)["attributes"]["NORMAL"] =
        add_compressed(draft, encode_attributes(filtered.data(), 3, stride), stride, "ATTRIBUTES", "OCTAHEDRAL",
                       {{"componentType", type}, {"count", 3}, {"type", "VEC3"}, {"normalized", true}});
    const Scene scene = read(draft);
    ASSERT_EQ(scene.meshes.size(), 1u);
    ASSERT_EQ(scene.meshes[0].normals.size(), 3u);
    for (int i = 0; i < 3; ++i) {
      const Vec3 expected(normals[4 * i], normals[4 * i + 1], normals[4 * i + 2]);
      EXPECT_LT(glm::distance(scene.meshes[0].normals[i], expected), stride == 4 ? 0.02f : 0.002f) << i;
    }
  }
}

TEST(GltfMeshopt, AppliesTheQuaternionAndExponentialFiltersToInstances) {
  GlbDraft draft;
  const float half = std::sqrt(0.5f);
  const std::vector<float> rotations = {0, 0, half, half, 0, 0, 0, 1};
  const std::vector<float> places = {5, 6, 7, -1000, 0.125f, 3};
  std::vector<char> filtered(2 * 8);
  meshopt_encodeFilterQuat(filtered.data(), 2, 8, 16, rotations.data());
  const int rotation =
      add_compressed(draft, encode_attributes(filtered.data(), 2, 8), 8, "ATTRIBUTES", "QUATERNION",
                     {{"componentType", kShort}, {"count", 2}, {"type", "VEC4"}, {"normalized", true}});
  filtered.resize(2 * 12);
  meshopt_encodeFilterExp(filtered.data(), 2, 12, 24, places.data());
  const int translation = add_compressed(draft, encode_attributes(filtered.data(), 2, 12), 12, "ATTRIBUTES",
                                         "EXPONENTIAL", {{"componentType", kFloat}, {"count", 2}, {"type", "VEC3"}});
  draft.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"ROTATION", rotation},
                                                                                   {"TRANSLATION", translation}};
  const Scene scene = read(draft);
  ASSERT_EQ(scene.instances.size(), 2u);
  const Bounds3 bounds = world_bounds(scene);
  // The first is turned by a quarter about z: it extends from x = 5 to the left.
  EXPECT_NEAR(bounds.max.x, 5, 1e-3);
  EXPECT_NEAR(bounds.max.y, 7, 1e-3);
  EXPECT_NEAR(bounds.max.z, 7, 1e-3);
  EXPECT_NEAR(bounds.min.x, -1000, 1e-3);
  EXPECT_NEAR(bounds.min.y, 0.125, 1e-3);
}

TEST(GltfMeshopt, NeverAsksForAFallbackBuffer) {
  GlbDraft draft = compressed_grid();
  draft.json["buffers"][1]["extensions"]["EXT_meshopt_compression"]["fallback"] = true;
  EXPECT_EQ(corners(read(draft)), corners_of_grid());
  draft.json["buffers"][1]["uri"] = "not%20there.bin";
  EXPECT_EQ(corners(read(draft)), corners_of_grid());
  draft.json["buffers"][1]["byteLength"] = 1'000'000'000'000'000;
  EXPECT_EQ(corners(read(draft)), corners_of_grid()) << "its length is no reason to take memory";
}

TEST(GltfMeshopt, ReadsJsonWithBuffersBesideIt) {
  const GlbDraft draft = compressed_grid();
  json document = draft.json;
  document["buffers"][0] = {{"byteLength", draft.bin.size()}, {"uri", "scene.bin"}};
  std::vector<std::string> asked;
  const ResourceReader reader = [&](const std::string& path) -> Result<std::vector<std::byte>> {
    asked.push_back(path);
    return test::bytes_of(draft.bin);
  };
  const Result<Scene> scene = read_gltf(test::bytes_of(document.dump()), reader);
  ASSERT_TRUE(scene.ok()) << scene.error().where << ": " << scene.error().message;
  EXPECT_EQ(corners(*scene), corners_of_grid());
  EXPECT_EQ(asked, std::vector<std::string>{"scene.bin"});
}

TEST(GltfMeshopt, RefusesWhatTheSpecificationForbids) {
  const std::string attributes = "/bufferViews/1/extensions/EXT_meshopt_compression/";
  const std::string triangles = "/bufferViews/2/extensions/EXT_meshopt_compression/";
  const std::string at_attributes = "bufferViews[1].extensions.EXT_meshopt_compression";
  const std::string at_triangles = "bufferViews[2].extensions.EXT_meshopt_compression";
  struct Damage {
    std::string pointer;
    json value;
    std::string where;
  };
  const Damage damages[] = {{attributes + "mode", "PICTURES", at_attributes + ".mode"},
                            {attributes + "mode", 0, at_attributes + ".mode"},
                            {attributes + "filter", "BLUR", at_attributes + ".filter"},
                            {attributes + "filter", "OCTAHEDRAL", at_attributes + ".byteStride"},
                            {attributes + "filter", "QUATERNION", at_attributes + ".byteStride"},
                            {attributes + "byteStride", 8, at_attributes + ".byteStride"},
                            {attributes + "byteStride", 0, at_attributes + ".byteStride"},
                            {attributes + "count", 440, at_attributes + ".count"},
                            {attributes + "count", 0, at_attributes + ".count"},
                            {attributes + "buffer", 2, at_attributes + ".buffer"},
                            {attributes + "buffer", 1, at_attributes},
                            {attributes + "byteOffset", 1'000'000, at_attributes},
                            {attributes + "byteLength", 1'000'000, at_attributes},
                            {attributes + "byteLength", 100, at_attributes},
                            {triangles + "filter", "EXPONENTIAL", at_triangles + ".filter"},
                            {triangles + "byteStride", 12, at_triangles + ".byteStride"},
                            {triangles + "mode", "INDICES", at_triangles + ".count"},
                            {triangles + "count", 2399, at_triangles + ".count"},
                            {"/bufferViews/1/byteLength", 12, at_attributes + ".count"},
                            {"/bufferViews/1/byteOffset", 12'000, "bufferViews[1]"},
                            {"/bufferViews/1/buffer", 2, "bufferViews[1].buffer"},
                            {"/bufferViews/0/buffer", 2, "bufferViews[0].buffer"},
                            {"/buffers/1/byteLength", 100, "bufferViews[1]"},
                            {"/buffers/1/extensions/EXT_meshopt_compression/fallback", 1,
                             "buffers[1].extensions.EXT_meshopt_compression.fallback"}};
  for (const Damage& damage : damages) {
    SCOPED_TRACE(damage.pointer + " = " + damage.value.dump());
    GlbDraft draft = compressed_grid();
    draft.json[json::json_pointer(damage.pointer)] = damage.value;
    const Error error = refusal(draft);
    EXPECT_EQ(error.where, damage.where) << error.message;
  }
}

TEST(GltfMeshopt, RefusesDamagedData) {
  for (const std::size_t view : {1, 2}) {
    GlbDraft draft = compressed_grid();
    const std::size_t offset = draft.json["bufferViews"][view]["extensions"]["EXT_meshopt_compression"]["byteOffset"];
    draft.bin[offset] = 'x';
    const Error error = refusal(draft);
    EXPECT_EQ(error.where, "bufferViews[" + std::to_string(view) + "].extensions.EXT_meshopt_compression");
    EXPECT_EQ(error.message, "data cannot be decompressed");
  }
}

TEST(GltfMeshopt, RefusesIndicesBeyondTheVertices) {
  GlbDraft draft;
  primitive(draft)["indices"] = add_compressed(draft, encode_triangles({0, 1, 3}), 4, "TRIANGLES", "NONE",
                                               {{"componentType", kUnsignedInt}, {"count", 3}, {"type", "SCALAR"}});
  EXPECT_EQ(refusal(draft).where, "meshes[0].primitives[0].indices");
}

TEST(GltfMeshopt, RefusesOrdinaryDataInABufferThatHasNone) {
  GlbDraft draft = compressed_grid();
  draft.json["bufferViews"][0]["buffer"] = 1;
  EXPECT_EQ(refusal(draft).where, "bufferViews[0]");
  GlbDraft plain;
  plain.json["buffers"][1] = {{"byteLength", 100}};
  EXPECT_EQ(refusal(plain).where, "buffers[1]") << "nothing is compressed";
  plain.json["buffers"][1]["extensions"]["EXT_meshopt_compression"]["fallback"] = true;
  EXPECT_EQ(refusal(plain).where, "buffers[1]");
}

// A kilobyte that claims to be gigabytes.
TEST(GltfMeshopt, RefusesMoreThanTheDataCanHold) {
  for (const char* mode : {"ATTRIBUTES", "TRIANGLES", "INDICES"}) {
    SCOPED_TRACE(mode);
    GlbDraft draft = compressed_grid();
    json& view = draft.json["bufferViews"][1];
    view.erase("byteStride");
    view["byteOffset"] = 0;
    view["byteLength"] = 3'000'000'000;
    draft.json["buffers"][1]["byteLength"] = 3'000'000'000;
    json& packed = view["extensions"]["EXT_meshopt_compression"];
    packed["mode"] = mode;
    packed["byteStride"] = 4;
    packed["count"] = 750'000'000;
    EXPECT_EQ(refusal(draft).where, "bufferViews[1].extensions.EXT_meshopt_compression.count");
  }
}

// As much as it can: 64 times its size; and the same data again and again.
TEST(GltfMeshopt, CountsAllThatIsUnpacked) {
  GlbDraft draft;
  const std::vector<float> zeros(3 * 4096, 0.0f);
  const std::string encoded = encode_attributes(zeros.data(), 4096, 12);
  EXPECT_LT(encoded.size(), zeros.size() * sizeof(float) / 40);
  const json accessor = {{"componentType", kFloat}, {"count", 4096}, {"type", "VEC3"}};
  add_compressed(draft, encoded, 12, "ATTRIBUTES", "NONE", accessor);
  const std::size_t bytes = encoded.size() + zeros.size() * sizeof(float);
  draft.json["bufferViews"].push_back(draft.json["bufferViews"][1]);
  EXPECT_TRUE(read_gltf(draft.pack(), no_resources(), {.max_decompressed_bytes = 2 * bytes}).ok());
  const Error error = refusal(draft, {.max_decompressed_bytes = 2 * bytes - 1});
  EXPECT_EQ(error.code, ErrorCode::limit_exceeded);
  EXPECT_EQ(error.where, "bufferViews[2].extensions.EXT_meshopt_compression");
}

}  // namespace
}  // namespace photond
