// Primitives under KHR_draco_mesh_compression.
#include <draco/compression/encode.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>

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

constexpr int kUnsignedByte = 5121, kUnsignedShort = 5123, kFloat = 5126;
constexpr const char* kWhere = "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression";

json& compression(GlbDraft& draft) { return primitive(draft)["extensions"]["KHR_draco_mesh_compression"]; }

/// A quarter of a bowl of side × side squares, all vertices with a normal, uv and a colour of bytes.
struct Bowl {
  draco::Mesh mesh;
  int positions = 0, normals = 0, uvs = 0, colors = 0;  ///< unique ids

  explicit Bowl(int side) {
    const int points = (side + 1) * (side + 1);
    mesh.set_num_points(static_cast<std::uint32_t>(points));
    positions = add<float, 3>(draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, points);
    normals = add<float, 3>(draco::GeometryAttribute::NORMAL, draco::DT_FLOAT32, points);
    uvs = add<float, 2>(draco::GeometryAttribute::TEX_COORD, draco::DT_FLOAT32, points);
    colors = add<std::uint8_t, 4>(draco::GeometryAttribute::COLOR, draco::DT_UINT8, points);
    for (int p = 0; p < points; ++p) {
      const float x = static_cast<float>(p % (side + 1)) / static_cast<float>(side);
      const float y = static_cast<float>(p / (side + 1)) / static_cast<float>(side);
      const Vec3 normal = glm::normalize(Vec3(-x, -y, 1));
      set(positions, p, std::array{x, y, (x * x + y * y) / 2});
      set(normals, p, std::array{normal.x, normal.y, normal.z});
      set(uvs, p, std::array{x, y});
      set(colors, p, std::array<std::uint8_t, 4>{static_cast<std::uint8_t>(255 * x), 51, 0, 255});
    }
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const auto a = static_cast<std::uint32_t>(y * (side + 1) + x);
        const std::uint32_t b = a + static_cast<std::uint32_t>(side) + 1;
        mesh.AddFace({draco::PointIndex(a), draco::PointIndex(a + 1), draco::PointIndex(b)});
        mesh.AddFace({draco::PointIndex(b), draco::PointIndex(a + 1), draco::PointIndex(b + 1)});
      }
    }
  }

  template <class T, int width>
  int add(draco::GeometryAttribute::Type type, draco::DataType data_type, int points) {
    draco::GeometryAttribute attribute;
    attribute.Init(type, nullptr, width, data_type, std::is_integral_v<T>, width * sizeof(T), 0);
    return mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(points));
  }
  template <class T>
  void set(int attribute, int point, const T& value) {
    const draco::AttributeValueIndex at(static_cast<std::uint32_t>(point));
    mesh.attribute(attribute)->SetAttributeValue(at, value.data());
  }
};

struct Encoding {
  int method = draco::MESH_EDGEBREAKER_ENCODING;
  int position_bits = 14;  ///< 0: as they are
  int speed = 5;
};

std::string encode(const draco::Mesh& mesh, const Encoding& encoding) {
  draco::Encoder encoder;
  encoder.SetEncodingMethod(encoding.method);
  encoder.SetSpeedOptions(encoding.speed, encoding.speed);
  if (encoding.position_bits > 0) {
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, encoding.position_bits);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, 12);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, 12);
  }
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
  return {buffer.data(), buffer.size()};
}

/// Puts `data` into buffer view 1 and names it as the mesh of the primitive.
void compress(GlbDraft& draft, const std::string& data, const json& ids) {
  const std::size_t offset = test::put(draft.bin, std::vector<char>(data.begin(), data.end()));
  draft.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", data.size()}});
  compression(draft) = {{"bufferView", draft.json["bufferViews"].size() - 1}, {"attributes", ids}};
}

int add_accessor(GlbDraft& draft, int component_type, std::size_t count, const char* type) {
  draft.json["accessors"].push_back({{"componentType", component_type}, {"count", count}, {"type", type}});
  if (component_type == kUnsignedByte) draft.json["accessors"].back()["normalized"] = true;
  return static_cast<int>(draft.json["accessors"].size()) - 1;
}

/// A file with the bowl alone. Accessors: 1 indices, 2 positions, 3 normals, 4 uv, 5 colours.
GlbDraft compressed_bowl(const Bowl& bowl, const Encoding& encoding = {}) {
  GlbDraft draft;
  const std::size_t points = bowl.mesh.num_points();
  primitive(draft)["indices"] = add_accessor(draft, kUnsignedShort, 3 * bowl.mesh.num_faces(), "SCALAR");
  primitive(draft)["attributes"] = {{"POSITION", add_accessor(draft, kFloat, points, "VEC3")},
                                    {"NORMAL", add_accessor(draft, kFloat, points, "VEC3")},
                                    {"TEXCOORD_0", add_accessor(draft, kFloat, points, "VEC2")},
                                    {"COLOR_0", add_accessor(draft, kUnsignedByte, points, "VEC4")}};
  const json ids = {
      {"POSITION", bowl.positions}, {"NORMAL", bowl.normals}, {"TEXCOORD_0", bowl.uvs}, {"COLOR_0", bowl.colors}};
  compress(draft, encode(bowl.mesh, encoding), ids);
  return draft;
}

/// Whether a mesh is the bowl of that many squares a side.
void expect_bowl(const Scene& scene, int side) {
  ASSERT_EQ(scene.meshes.size(), 1u);
  const Mesh& mesh = scene.meshes[0];
  EXPECT_EQ(mesh.triangles.size(), 2u * side * side);
  double area = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const Vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
    const Vec3 normal = glm::cross(b - a, c - a);
    EXPECT_GT(normal.z, 0);
    area += 0.5 * normal.z;
  }
  EXPECT_NEAR(area, 1, 1e-3);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3 p = mesh.positions[i];
    EXPECT_NEAR(p.z, (p.x * p.x + p.y * p.y) / 2, 1e-3);
    EXPECT_LT(glm::distance(mesh.normals[i], glm::normalize(Vec3(-p.x, -p.y, 1))), 2e-3);
    EXPECT_LT(glm::distance(mesh.uv[0][i], Vec2(p)), 1e-3);
    EXPECT_LT(glm::distance(mesh.colors[i], Vec4(p.x, 0.2, 0, 1)), 5e-3);
  }
}

TEST(GltfDraco, ReadsEveryMethod) {
  const Bowl bowl(9);
  for (const int method : {draco::MESH_EDGEBREAKER_ENCODING, draco::MESH_SEQUENTIAL_ENCODING}) {
    for (const int bits : {14, 0}) {
      for (const int speed : {0, 5, 10}) {
        SCOPED_TRACE(testing::Message() << "method " << method << " bits " << bits << " speed " << speed);
        const Scene scene = read(compressed_bowl(bowl, {method, bits, speed}));
        expect_bowl(scene, 9);
        EXPECT_EQ(scene.warnings.size(), 2u) << "of the camera and the light that are missing";
      }
    }
  }
}

TEST(GltfDraco, MapsAttributesByTheirUniqueId) {
  Bowl bowl(4);
  bowl.mesh.attribute(bowl.positions)->set_unique_id(40);
  bowl.mesh.attribute(bowl.normals)->set_unique_id(7);
  bowl.positions = 40;
  bowl.normals = 7;
  expect_bowl(read(compressed_bowl(bowl)), 4);
}

TEST(GltfDraco, ReadsJsonAndRequiredExtensions) {
  GlbDraft draft = compressed_bowl(Bowl(4));
  draft.json["extensionsUsed"] = draft.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  expect_bowl(read(draft), 4);
  json document = draft.json;
  document["buffers"][0] = {{"byteLength", draft.bin.size()}, {"uri", "a.bin"}};
  const ResourceReader reader = [&](const std::string&) -> Result<std::vector<std::byte>> {
    return test::bytes_of(draft.bin);
  };
  const Result<Scene> scene = read_gltf(test::bytes_of(document.dump()), reader);
  ASSERT_TRUE(scene.ok()) << scene.error().where << ": " << scene.error().message;
  expect_bowl(*scene, 4);
}

TEST(GltfDraco, ReadsAFileWithoutIndices) {
  GlbDraft draft = compressed_bowl(Bowl(4));
  primitive(draft).erase("indices");
  expect_bowl(read(draft), 4);
  compression(draft)["indices"] = 77;  // means nothing there
  expect_bowl(read(draft), 4);
}

TEST(GltfDraco, ReadsStripsAsTheTrianglesThatAreThere) {
  GlbDraft draft = compressed_bowl(Bowl(4));
  primitive(draft)["mode"] = 5;
  draft.json["accessors"][1]["count"] = 60;
  expect_bowl(read(draft), 4);
}

TEST(GltfDraco, PrefersCompressedToOrdinaryData) {
  GlbDraft draft = compressed_bowl(Bowl(4));
  const std::vector<float> elsewhere(3 * 25, 9.0f);
  const int ordinary = draft.add_accessor(elsewhere, kFloat, "VEC3", 3);
  primitive(draft)["attributes"]["POSITION"] = ordinary;
  expect_bowl(read(draft), 4);
}

TEST(GltfDraco, TakesOtherAttributesAndTargetsFromOrdinaryData) {
  const Bowl bowl(1);
  GlbDraft draft = compressed_bowl(bowl, {.method = draco::MESH_SEQUENTIAL_ENCODING, .position_bits = 0});
  compression(draft)["attributes"].erase("TEXCOORD_0");
  primitive(draft)["attributes"]["TEXCOORD_0"] = draft.add_accessor<float>({9, 8, 7, 6, 5, 4, 3, 2}, kFloat, "VEC2", 2);
  const int target = draft.add_accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3", 3);
  primitive(draft)["targets"] = {{{"POSITION", target}}};
  draft.json["meshes"][0]["weights"] = {3};
  const Scene scene = read(draft);
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.meshes[0].uv[0][1], Vec2(7, 6));
  EXPECT_EQ(scene.meshes[0].positions[1], Vec3(1, 0, 3.5));
}

// Accessors without a buffer view say nothing about where their data is, and writers may use one for several meshes.
TEST(GltfDraco, PrimitivesMayShareAccessorsAndData) {
  const Bowl bowl(4);
  GlbDraft draft = compressed_bowl(bowl);
  json second = primitive(draft);
  draft.json["meshes"][0]["primitives"].push_back(second);
  Bowl lifted(4);
  for (int p = 0; p < 25; ++p) {
    lifted.set(lifted.positions, p, std::array{static_cast<float>(p % 5), static_cast<float>(p / 5), 8.0f});
  }
  json& third = draft.json["meshes"][0]["primitives"].emplace_back(second);
  const std::string data = encode(lifted.mesh, {});
  const std::size_t offset = test::put(draft.bin, std::vector<char>(data.begin(), data.end()));
  draft.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", data.size()}});
  third["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = draft.json["bufferViews"].size() - 1;
  const Scene scene = read(draft);
  ASSERT_EQ(scene.meshes.size(), 3u);
  EXPECT_EQ(scene.meshes[0].positions, scene.meshes[1].positions);
  for (const Vec3& p : scene.meshes[2].positions) EXPECT_NEAR(p.z, 8, 1e-3);
}

TEST(GltfDraco, PassesOverMetadata) {
  Bowl bowl(4);
  auto of_attribute = std::make_unique<draco::AttributeMetadata>();
  of_attribute->AddEntryString("attribute_name", "COLOR_0");
  bowl.mesh.AddAttributeMetadata(bowl.colors, std::move(of_attribute));
  auto inside = std::make_unique<draco::Metadata>();
  inside->AddEntryInt("year", 2026);
  bowl.mesh.metadata()->AddSubMetadata("inside", std::move(inside));
  bowl.mesh.metadata()->AddEntryString("name", std::string(300, 'x'));
  expect_bowl(read(compressed_bowl(bowl)), 4);
}

TEST(GltfDraco, RefusesWhatDoesNotMatch) {
  const std::string primitive_at = "/meshes/0/primitives/0/";
  const std::string draco = primitive_at + "extensions/KHR_draco_mesh_compression/";
  const std::string where = kWhere, plain = "meshes[0].primitives[0].attributes.";
  struct Damage {
    std::string pointer;
    json value;
    std::string where;
  };
  const Damage damages[] = {{draco + "bufferView", 2, where + ".bufferView"},
                            {draco + "bufferView", -1, where + ".bufferView"},
                            {draco + "bufferView", 0, where},
                            {draco + "attributes", json::array(), where + ".attributes"},
                            {draco + "attributes/TANGENT", 0, where + ".attributes.TANGENT"},
                            {draco + "attributes/NORMAL", 9, where + ".attributes.NORMAL"},
                            {draco + "attributes/NORMAL", 2, where + ".attributes.NORMAL"},
                            {draco + "attributes/COLOR_0", 0, where + ".attributes.COLOR_0"},
                            {primitive_at + "mode", 0, where},
                            {primitive_at + "indices", 17, where},
                            {primitive_at + "attributes/NORMAL", 17, plain + "NORMAL"},
                            // The accessors after the file's own are those of unpacked data.
                            {primitive_at + "attributes/NORMAL", 6, plain + "NORMAL"},
                            {"/bufferViews/0/buffer", 1, "bufferViews[0].buffer"},
                            {"/accessors/1/count", 95, where},
                            {"/accessors/2/count", 24, plain + "COLOR_0"},
                            {"/accessors/3/componentType", kUnsignedByte, plain + "NORMAL"},
                            {"/accessors/5/componentType", 5120, plain + "COLOR_0"},
                            {"/accessors/5/componentType", 1, "accessors[5]"},
                            {"/bufferViews/1/byteLength", 100'000, "bufferViews[1]"},
                            {"/bufferViews/1/byteLength", 80, where}};
  const Bowl bowl(4);
  for (const Damage& damage : damages) {
    SCOPED_TRACE(damage.pointer + " = " + damage.value.dump());
    GlbDraft draft = compressed_bowl(bowl);
    draft.json[json::json_pointer(damage.pointer)] = damage.value;
    const Error error = refusal(draft);
    EXPECT_EQ(error.where, damage.where) << error.message;
  }
  GlbDraft draft = compressed_bowl(bowl);
  for (int i = 2; i <= 5; ++i) draft.json["accessors"][i]["count"] = 24;
  EXPECT_EQ(refusal(draft).where, where + ".attributes.COLOR_0") << "25 points are there";
  draft = compressed_bowl(bowl);
  compression(draft).erase("bufferView");
  EXPECT_EQ(refusal(draft).where, kWhere);
}

/// Where the stream begins.
char* stream(GlbDraft& draft) {
  return draft.bin.data() + draft.json["bufferViews"][1]["byteOffset"].get<std::size_t>();
}

TEST(GltfDraco, RefusesOtherVersionsAndMethods) {
  GlbDraft draft = compressed_bowl(Bowl(4));
  stream(draft)[6] = 1;
  EXPECT_EQ(refusal(draft).code, ErrorCode::unsupported) << "an old version";
  stream(draft)[6] = 2;
  stream(draft)[8] = 2;
  EXPECT_EQ(refusal(draft).code, ErrorCode::unsupported) << "an unknown method";
  stream(draft)[7] = 0;
  EXPECT_EQ(refusal(draft).message, "data is not a mesh compressed by Draco") << "a cloud of points";
  EXPECT_EQ(refusal(draft).where, kWhere);
}

TEST(GltfDraco, RefusesIndicesBeyondTheVertices) {
  GlbDraft draft = compressed_bowl(Bowl(1), {.method = draco::MESH_SEQUENTIAL_ENCODING, .speed = 10});
  // Behind the header: the numbers of faces and points, the kind of connectivity, and a byte for each corner.
  ASSERT_EQ(stream(draft)[13], 1);
  stream(draft)[14] = 100;
  EXPECT_EQ(refusal(draft).where, "meshes[0].primitives[0].indices");
}

TEST(GltfDraco, RefusesPositionsThatAreNotFinite) {
  Bowl bowl(1);
  bowl.set(bowl.positions, 2, std::array{0.0f, std::nanf(""), 0.0f});
  GlbDraft draft = compressed_bowl(bowl, {.position_bits = 0});
  EXPECT_EQ(refusal(draft).where, std::string(kWhere) + ".attributes.POSITION");
}

TEST(GltfDraco, CountsAllThatIsUnpacked) {
  const Bowl bowl(40);
  GlbDraft draft = compressed_bowl(bowl);
  // 3200 triangles: 38 kB of indices, 73 kB of attributes, and what the decoder needs meanwhile.
  EXPECT_TRUE(read_gltf(draft.pack(), no_resources(), {.max_decompressed_bytes = 1'000'000}).ok());
  for (const std::uint64_t bytes : {100, 10'000, 100'000}) {
    const Error error = refusal(draft, {.max_decompressed_bytes = bytes});
    EXPECT_EQ(error.code, ErrorCode::limit_exceeded) << bytes;
    EXPECT_EQ(error.where, kWhere) << bytes;
  }
  for (int i = 0; i < 20; ++i) draft.json["meshes"][0]["primitives"].push_back(json(primitive(draft)));
  EXPECT_TRUE(read_gltf(draft.pack(), no_resources()).ok());
  EXPECT_THAT(refusal(draft, {.max_decompressed_bytes = 1'000'000}).where, HasSubstr("KHR_draco_mesh_compression"));
  EXPECT_EQ(refusal(draft, {.max_triangles = 60'000}).where, "meshes[0].primitives[18]");
}

std::string varint(std::uint32_t value) {
  std::string out;
  for (; value > 127; value >>= 7) out.push_back(static_cast<char>((value & 127) | 128));
  out.push_back(static_cast<char>(value));
  return out;
}

Error refusal_of_stream(const std::string& data) {
  GlbDraft draft;
  compress(draft, data, {{"POSITION", 0}});
  const auto start = std::chrono::steady_clock::now();
  const Error error = refusal(draft);
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 0.5);
  EXPECT_EQ(error.where, kWhere);
  return error;
}

// Streams of a few bytes.
TEST(GltfDraco, RefusesHugeClaims) {
  const std::string edgebreaker("DRACO\2\2\1\1\0\0", 11), sequential("DRACO\2\2\1\0\0\0", 11);
  const std::string zeros(64, '\0');
  const auto connectivity = [&](std::uint32_t vertices, std::uint32_t faces, char seams) {
    return edgebreaker + '\0' + varint(vertices) + varint(faces) + seams + varint(faces) + varint(0) + zeros;
  };
  EXPECT_EQ(refusal_of_stream(connectivity(1000, 1'000'000'000, 0)).code, ErrorCode::limit_exceeded);
  EXPECT_EQ(refusal_of_stream(connectivity(100'000'000, 100'000'000, 0)).code, ErrorCode::limit_exceeded);
  EXPECT_EQ(refusal_of_stream(connectivity(1000, 1'000'000, '\xff')).code, ErrorCode::limit_exceeded);
  EXPECT_EQ(refusal_of_stream(sequential + varint(1'000'000'000) + varint(3) + zeros).code, ErrorCode::limit_exceeded);
  EXPECT_EQ(refusal_of_stream(sequential + varint(2) + varint(1'000'000'000) + zeros).code, ErrorCode::invalid_input);
  // One triangle, and as many attributes as there are bytes.
  const std::string triangle = sequential + varint(1) + varint(3) + std::string("\1\0\1\2", 4);
  EXPECT_EQ(refusal_of_stream(triangle + '\1' + varint(200'000) + std::string(1'000'000, '\1')).code,
            ErrorCode::invalid_input);
}

// Each split gives all triangles around a vertex another one, and the next split the same again.
TEST(GltfDraco, RefusesStreamsThatTakeTheSquareOfTheirLength) {
  constexpr std::uint32_t kSplits = 30'000;
  std::string bits;
  for (std::uint32_t i = 0; i <= kSplits; ++i) bits += "111";    // a triangle by itself
  for (std::uint32_t i = 0; i < kSplits; ++i) bits += "10000";  // one that splits, two that close
  std::string symbols((bits.size() + 7) / 8, '\0');
  for (std::size_t i = 0; i < bits.size(); ++i) symbols[i / 8] |= static_cast<char>((bits[i] - '0') << i % 8);
  const std::uint32_t faces = 4 * kSplits + 1;
  const std::string counts = varint(3 * kSplits + 3) + varint(faces) + '\0' + varint(faces) + varint(kSplits);
  const std::string size = varint(static_cast<std::uint32_t>(symbols.size()));
  GlbDraft draft;
  compress(draft,
           std::string("DRACO\2\2\1\1\0\0\0", 12) + counts + '\0' + size + symbols + '\x80' + varint(2) +
               std::string(300, '\0'),
           {{"POSITION", 0}});
  const Error error = refusal(draft, {.max_decompression_seconds = 1});
  EXPECT_EQ(error.code, ErrorCode::limit_exceeded);
  EXPECT_EQ(error.where, "meshes");
}

// Each piece inside claims that as many pieces follow as there are bytes.
TEST(GltfDraco, RefusesMetadataOfManyPieces) {
  std::string data("DRACO\2\2\1\1\0\x80\0\0", 13);
  for (int i = 0; i < 100'000; ++i) data += varint(100'000) + std::string(2, '\0');
  refusal_of_stream(data);
}

}  // namespace
}  // namespace photond
