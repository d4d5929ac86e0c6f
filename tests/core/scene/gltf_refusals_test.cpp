#include "core/scene/gltf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/read_draft.h"

namespace photond {
namespace {

using nlohmann::json;
using test::GlbDraft;
using test::primitive;
using test::read;
using test::refusal;
using testing::HasSubstr;

constexpr int kUnsignedInt = 5125, kFloat = 5126;

TEST(GltfRefusals, NeverAsksForAPathOutside) {
  for (const char* uri :
       {"../x.bin", "a/../../x.bin", "%2e%2e/x.bin", "/etc/passwd", "file:///etc/passwd",
        "http://example.com/x.bin", "a\\..\\x.bin", "C:/x.bin", "a//b", "", ".", "./../x.bin", "x%00.bin", "%2"}) {
    SCOPED_TRACE(uri);
    GlbDraft draft;
    json document = draft.json;
    document["buffers"] = json::array({{{"byteLength", draft.bin.size()}, {"uri", uri}}});
    const ResourceReader reader = [&](const std::string& path) -> Result<std::vector<std::byte>> {
      ADD_FAILURE() << "asked for " << path;
      return test::bytes_of(draft.bin);
    };
    const Result<Scene> scene = read_gltf(test::bytes_of(document.dump()), reader);
    ASSERT_FALSE(scene.ok());
    EXPECT_THAT(scene.error().where, HasSubstr("buffers[0]"));
  }
}

TEST(GltfRefusals, RefusesRequiredExtensionsByName) {
  GlbDraft draft;
  draft.json["extensionsRequired"] = {"KHR_texture_basisu"};
  const Error error = refusal(draft);
  EXPECT_EQ(error.code, ErrorCode::unsupported);
  EXPECT_THAT(error.message, HasSubstr("KHR_texture_basisu"));
}

struct Damage {
  const char* pointer;
  json value;
  const char* where;
};

TEST(GltfRefusals, RefusesBrokenReferencesAndValuesWithTheirPlace) {
  const Damage damages[] = {
      {"/scene", 5, "scene"},
      {"/scenes/0/nodes/0", 9, "scenes[0].nodes[0]"},
      {"/nodes/0/mesh", 3, "nodes[0].mesh"},
      {"/nodes/0/children", {0}, "nodes[0]"},
      {"/nodes/0/mesh", -1, "nodes[0].mesh"},
      {"/nodes/0/mesh", "0", "nodes[0].mesh"},
      {"/nodes/0/mesh", 0.5, "nodes[0].mesh"},
      {"/nodes/0/scale", {1, 1}, "nodes[0].scale"},
      {"/nodes/0/translation", {1e30, 0, 0}, "nodes[0]"},
      {"/nodes/0/rotation", {0, 0, 0, 0}, "nodes[0].rotation"},
      {"/meshes/0/primitives/0/material", 0, "meshes[0].primitives[0].material"},
      {"/meshes/0/primitives/0/mode", 7, "meshes[0].primitives[0].mode"},
      {"/meshes/0/primitives/0/attributes/POSITION", 4, "meshes[0].primitives[0].attributes.POSITION"},
      {"/meshes/0/primitives", json::array(), "meshes[0].primitives"},
      {"/accessors/0/count", 4, "accessors[0]"},
      {"/accessors/0/count", 0, "accessors[0].count"},
      {"/accessors/0/count", 1e15, "accessors[0].count"},
      {"/accessors/0/byteOffset", 2, "accessors[0]"},
      {"/accessors/0/componentType", 5124, "accessors[0].componentType"},
      {"/accessors/0/bufferView", 1, "accessors[0].bufferView"},
      {"/bufferViews/0/byteLength", 1000, "bufferViews[0]"},
      {"/bufferViews/0/buffer", 1, "bufferViews[0].buffer"},
      {"/asset/version", "1.0", "asset.version"}};
  for (const Damage& damage : damages) {
    SCOPED_TRACE(std::string(damage.pointer) + " = " + damage.value.dump());
    GlbDraft draft;
    draft.json[json::json_pointer(damage.pointer)] = damage.value;
    const Error error = refusal(draft);
    EXPECT_FALSE(error.message.empty());
    EXPECT_EQ(error.where, damage.where);
  }
}

TEST(GltfRefusals, RefusesMaterialValuesOutOfRange) {
  const Damage damages[] = {
      {"/pbrMetallicRoughness/metallicFactor", 1.5, "materials[0].pbrMetallicRoughness.metallicFactor"},
      {"/pbrMetallicRoughness/baseColorFactor", {1, 1, 1}, "materials[0].pbrMetallicRoughness.baseColorFactor"},
      {"/pbrMetallicRoughness/baseColorTexture/index", 0,
       "materials[0].pbrMetallicRoughness.baseColorTexture.index"},
      {"/alphaMode", "GHOST", "materials[0].alphaMode"},
      {"/emissiveFactor", {2, 0, 0}, "materials[0].emissiveFactor[0]"},
      {"/extensions/KHR_materials_ior/ior", 0.5, "materials[0].extensions.KHR_materials_ior.ior"},
      {"/extensions/KHR_materials_dispersion/dispersion", -1, "materials[0].extensions.KHR_materials_dispersion.dispersion"},
      {"/extensions/KHR_materials_dispersion/dispersion", 1e30,
       "materials[0].extensions.KHR_materials_dispersion.dispersion"},
      {"/extensions/KHR_materials_volume/attenuationDistance", 0,
       "materials[0].extensions.KHR_materials_volume.attenuationDistance"},
      {"/extensions/KHR_materials_anisotropy/anisotropyStrength", 1.5,
       "materials[0].extensions.KHR_materials_anisotropy.anisotropyStrength"},
      {"/extensions/KHR_materials_anisotropy/anisotropyRotation", 1e30,
       "materials[0].extensions.KHR_materials_anisotropy.anisotropyRotation"},
      {"/extensions/KHR_materials_anisotropy/anisotropyRotation", "left",
       "materials[0].extensions.KHR_materials_anisotropy.anisotropyRotation"},
      {"/extensions/KHR_materials_sheen/sheenColorFactor", {0, 1.5, 0},
       "materials[0].extensions.KHR_materials_sheen.sheenColorFactor[1]"},
      {"/extensions/KHR_materials_sheen/sheenColorFactor", {0.5, 0.5},
       "materials[0].extensions.KHR_materials_sheen.sheenColorFactor"},
      {"/extensions/KHR_materials_sheen/sheenRoughnessFactor", -0.1,
       "materials[0].extensions.KHR_materials_sheen.sheenRoughnessFactor"},
      {"/extensions/KHR_materials_sheen/sheenRoughnessFactor", "soft",
       "materials[0].extensions.KHR_materials_sheen.sheenRoughnessFactor"}};
  for (const Damage& damage : damages) {
    SCOPED_TRACE(damage.pointer);
    GlbDraft draft;
    draft.json["materials"] = json::array({json::object()});
    draft.json["materials"][0][json::json_pointer(damage.pointer)] = damage.value;
    EXPECT_EQ(refusal(draft).where, damage.where);
  }
}

TEST(GltfRefusals, SaysWhichValuesAreAllowed) {
  const std::pair<const char*, const char*> ranges[] = {{"metallicFactor", "must be from 0 to 1"}, {"roughnessFactor", "must be from 0 to 1"}};
  for (const auto& [factor, words] : ranges) {
    GlbDraft draft;
    draft.json["materials"] = json::array({{{"pbrMetallicRoughness", {{factor, 1.5}}}}});
    EXPECT_EQ(refusal(draft).message, words);
  }
  GlbDraft draft;
  draft.json["nodes"][0]["mesh"] = -1;
  EXPECT_EQ(refusal(draft).message, "must be from 0 to 2147483647");
}

TEST(GltfRefusals, SaysThatAFileIsNoGltf) {
  for (const char* text : {"not a scene", "[]", "null", "  ", "PK\x03\x04"}) {
    const Result<Scene> scene = read_gltf(test::bytes_of(std::string(text)), no_resources());
    ASSERT_FALSE(scene.ok());
    EXPECT_EQ(scene.error().message, "the file is neither GLB nor the JSON of a glTF") << text;
  }
}

TEST(GltfRefusals, NamesTheIndicesWhoseAccessorHasNoData) {
  GlbDraft draft;
  draft.json["accessors"].push_back({{"componentType", kUnsignedInt}, {"count", 3}, {"type", "SCALAR"}});
  draft.json["materials"] = json::array({json::object()});
  json& primitives = draft.json["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  primitives[1]["indices"] = 1;
  EXPECT_EQ(refusal(draft).where, "meshes[0].primitives[1].indices");
  primitives[1]["indices"] = 2;
  EXPECT_EQ(refusal(draft).where, "meshes[0].primitives[1].indices") << "no such accessor";
}

TEST(GltfRefusals, NamesTheLightWithoutItsCone) {
  GlbDraft draft;
  draft.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}, {{"type", "spot"}}};
  EXPECT_EQ(refusal(draft).where, "extensions.KHR_lights_punctual.lights[1]");
}

TEST(GltfRefusals, KeepsThePlaceOfDeepMistakesShort) {
  GlbDraft draft;
  json deep = 1;
  for (int i = 0; i < 1000; ++i) deep = json::array({deep});
  draft.json["extras"] = deep;
  const Error error = refusal(draft);
  EXPECT_EQ(error.code, ErrorCode::limit_exceeded);
  EXPECT_THAT(error.where, HasSubstr("extras[0][0]"));
  EXPECT_LT(error.where.size(), 100u);
}

TEST(GltfRefusals, RefusesIndicesBeyondTheVertices) {
  GlbDraft draft;
  primitive(draft)["indices"] = draft.add_accessor<std::uint32_t>({0, 1, 3}, kUnsignedInt, "SCALAR", 1);
  EXPECT_EQ(refusal(draft).where, "meshes[0].primitives[0].indices");
}

TEST(GltfRefusals, RefusesPositionsThatAreNotFinite) {
  GlbDraft draft;
  const float nan = std::nanf("");
  primitive(draft)["attributes"]["POSITION"] =
      draft.add_accessor<float>({0, 0, 0, 1, 0, 0, 0, nan, 0}, kFloat, "VEC3", 3);
  EXPECT_EQ(refusal(draft).where, "accessors[1]");
}

TEST(GltfRefusals, RefusesWhatExceedsTheLimits) {
  GlbDraft draft;
  EXPECT_EQ(refusal(draft, {.max_vertices = 2}).code, ErrorCode::limit_exceeded);
  EXPECT_EQ(refusal(draft, {.max_triangles = 0}).code, ErrorCode::limit_exceeded);
  EXPECT_EQ(refusal(draft, {.max_instances = 0}).code, ErrorCode::limit_exceeded);
  EXPECT_EQ(refusal(draft, {.max_placed_triangles = 0}).code, ErrorCode::limit_exceeded);
  EXPECT_EQ(refusal(draft, {.max_nodes = 0}).code, ErrorCode::limit_exceeded);
  draft.json["materials"] = json::array({json::object(), json::object()});
  EXPECT_EQ(refusal(draft, {.max_materials = 1}).where, "materials");
  EXPECT_EQ(refusal(draft, {.max_json_objects = 5}).code, ErrorCode::limit_exceeded);
  EXPECT_EQ(refusal(draft, {.max_json_depth = 3}).code, ErrorCode::limit_exceeded);
}

// A small mesh that shines, placed many times.
TEST(GltfRefusals, RefusesTooManyPlacedTriangles) {
  GlbDraft draft;
  draft.json["materials"] = {{{"emissiveFactor", {1, 1, 1}}}};
  primitive(draft)["material"] = 0;
  draft.json["nodes"].push_back({{"mesh", 0}});
  draft.json["scenes"][0]["nodes"] = {0, 1};
  EXPECT_EQ(read(draft).instances.size(), 2u);
  EXPECT_EQ(refusal(draft, {.max_placed_triangles = 1}).where, "nodes[1]");
  EXPECT_EQ(refusal(draft, {.max_emitters = 1}).where, "nodes[1]");
}

TEST(GltfRefusals, SurvivesLongChainsOfNodes) {
  GlbDraft draft;
  for (int i = 0; i < 50'000; ++i) draft.json["nodes"].push_back({{"children", {i + 2}}});
  draft.json["nodes"].push_back({{"mesh", 0}});
  draft.json["scenes"][0]["nodes"] = {1};
  EXPECT_EQ(read(draft).instances.size(), 1u);
}

}  // namespace
}  // namespace photond
