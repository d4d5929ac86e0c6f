#include "core/scene/gltf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/film/encode.h"
#include "core/math/frame.h"
#include "tests/support/glb.h"

namespace photond {
namespace {

using nlohmann::json;
using test::GlbDraft;
using testing::Contains;
using testing::HasSubstr;

constexpr int kByte = 5120, kUnsignedByte = 5121, kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;

Scene read(const GlbDraft& draft) {
  Result<Scene> scene = read_gltf(draft.pack(), no_resources());
  EXPECT_TRUE(scene.ok()) << scene.error().where << ": " << scene.error().message;
  return scene ? std::move(*scene) : Scene{};
}

json& primitive(GlbDraft& draft) { return draft.json["meshes"][0]["primitives"][0]; }

TEST(Gltf, ReadsATriangleAndStatesItsDefaults) {
  const Scene scene = read(GlbDraft());
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.meshes[0].positions[1], Vec3(1, 0, 0));
  EXPECT_EQ(scene.meshes[0].triangles, std::vector<glm::uvec3>({{0, 1, 2}}));
  EXPECT_TRUE(scene.meshes[0].normals.empty());
  EXPECT_EQ(scene.materials[scene.meshes[0].material].name, "default");
  EXPECT_EQ(scene.environment.radiance, Rgb(1));
  ASSERT_EQ(scene.cameras.size(), 1u);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("default camera")));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("environment")));
}

// A label that glows was made to be seen in somebody else's light; a lamp was not.
TEST(Gltf, OnlyBrightEmissionReplacesTheDefaultLight) {
  GlbDraft draft;
  Image white(1, 1);
  white.pixels = {Rgb(1)};
  const std::vector<std::byte> png = *encode(white, ImageFormat::png);
  const std::size_t offset = test::put(draft.bin, png);
  draft.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", png.size()}});
  const std::size_t view = draft.json["bufferViews"].size() - 1;
  draft.json["images"] = json::array({{{"bufferView", view}, {"mimeType", "image/png"}}});
  draft.json["textures"] = json::array({{{"source", 0}}});
  draft.json["materials"] = json::array({{{"emissiveFactor", {1, 1, 1}}, {"emissiveTexture", {{"index", 0}}}}});
  primitive(draft)["attributes"]["TEXCOORD_0"] = draft.add_accessor<float>({0, 0, 1, 0, 0, 1}, 5126, "VEC2", 2);
  primitive(draft)["material"] = 0;
  EXPECT_TRUE(read(draft).environment.active());
  draft.json["extensionsUsed"] = {"KHR_materials_emissive_strength"};
  draft.json["materials"][0]["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 5;
  EXPECT_FALSE(read(draft).environment.active());
}

TEST(Gltf, DefaultCameraSeesTheWholeBounds) {
  const Scene scene = read(GlbDraft());
  const Camera& camera = scene.cameras[0];
  for (const Vec3& p : scene.meshes[0].positions) {
    const Vec3 v = glm::transpose(glm::mat3(camera.to_world)) * (p - camera.to_world[3]);
    ASSERT_LT(v.z, 0);
    EXPECT_LT(std::abs(v.y / v.z), std::tan(0.5f * camera.yfov));
    EXPECT_LT(std::abs(v.x / v.z), std::tan(0.5f * camera.yfov));
  }
}

TEST(Gltf, ComposesNodeTransforms) {
  GlbDraft draft;
  const double half = std::sqrt(0.5);
  draft.json["nodes"] = json::array({{{"children", {1}}, {"translation", {10, 0, 0}}},
                                     {{"mesh", 0}, {"rotation", {0, 0, half, half}}, {"scale", {2, 3, 4}}}});
  const Scene scene = read(draft);
  // Scaled by 2 along x, turned by 90° about z onto y, moved.
  EXPECT_LT(glm::length(transform_point(scene.instances[0].to_world, {1, 0, 0}) - Vec3(10, 2, 0)), 1e-6f);
  EXPECT_LT(glm::length(transform_point(scene.instances[0].to_world, {0, 1, 0}) - Vec3(7, 0, 0)), 1e-6f);
}

// A plane that is scaled by 0 along its normal stays what it is; so does what a turned parent flattens.
TEST(Gltf, ShowsMeshesThatAreFlattened) {
  GlbDraft draft;
  primitive(draft)["attributes"]["POSITION"] =
      draft.add_accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, kFloat, "VEC3", 3);
  primitive(draft)["indices"] = draft.add_accessor<std::uint32_t>({0, 1, 2, 0, 3, 1}, kUnsignedInt, "SCALAR", 1);
  const double half = std::sqrt(0.5);
  const json turned = {half, 0, 0, half};   // +Y to +Z
  draft.json["nodes"] = {{{"mesh", 0}, {"scale", {2, 3, 0}}, {"translation", {0, 0, 7}}},
                         {{"scale", {1, 0, 1}}, {"children", {2}}},
                         {{"mesh", 0}, {"rotation", turned}},
                         {{"mesh", 0}, {"scale", {0, 1, 0}}}};
  draft.json["scenes"][0]["nodes"] = {0, 1, 3};
  const Scene scene = read(draft);
  ASSERT_EQ(scene.instances.size(), 2u);
  const auto in_first = [&](const Vec3& p) { return transform_point(scene.instances[0].to_world, p); };
  EXPECT_EQ(in_first({1, 0, 0}), Vec3(2, 0, 7));
  EXPECT_EQ(in_first({0, 1, 0}), Vec3(0, 3, 7));
  EXPECT_NEAR(in_first({0, 0, 1}).z, 7, 1e-5);
  EXPECT_GT(in_first({0, 0, 1}).z, 7) << "the front stays in front";
  const auto in_second = [&](const Vec3& p) { return transform_point(scene.instances[1].to_world, p); };
  EXPECT_LT(glm::length(in_second({0, 1, 0}) - Vec3(0, 0, 1)), 1e-5f);
  EXPECT_LT(glm::length(in_second({0, 0, 1}) - Vec3(0)), 1e-5f);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("nodes[3]: transform leaves nothing")));
}

TEST(Gltf, SharesTheMeshBetweenInstances) {
  GlbDraft draft;
  draft.json["nodes"] = json::array({{{"mesh", 0}}, {{"mesh", 0}, {"translation", {1, 2, 3}}}});
  draft.json["scenes"][0]["nodes"] = {0, 1};
  const Scene scene = read(draft);
  EXPECT_EQ(scene.meshes.size(), 1u);
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(scene.instances[1].to_world[3], Vec3(1, 2, 3));
}

TEST(Gltf, ReadsGpuInstancing) {
  GlbDraft draft;
  const int places = draft.add_accessor<float>({0, 0, 0, 5, 6, 7}, kFloat, "VEC3", 3);
  draft.json["extensionsUsed"] = draft.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  draft.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = places;
  const Scene scene = read(draft);
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(scene.instances[1].to_world[3], Vec3(5, 6, 7));
}

TEST(Gltf, ReadsStripsAndFans) {
  for (const auto& [mode, expected] :
       {std::pair<int, std::vector<glm::uvec3>>{5, {{0, 1, 2}, {1, 3, 2}}}, {6, {{1, 2, 0}, {2, 3, 0}}}}) {
    GlbDraft draft;
    primitive(draft)["attributes"]["POSITION"] =
        draft.add_accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 2, 0}, kFloat, "VEC3", 3);
    primitive(draft)["mode"] = mode;
    EXPECT_EQ(read(draft).meshes[0].triangles, expected) << "mode " << mode;
  }
}

TEST(Gltf, SkipsPointsAndLinesWithAWarning) {
  GlbDraft draft;
  json points = primitive(draft);
  points["mode"] = 0;
  draft.json["meshes"][0]["primitives"].push_back(points);
  const Scene scene = read(draft);
  EXPECT_EQ(scene.meshes.size(), 1u);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("meshes[0].primitives[1]: points")));
}

TEST(Gltf, DecodesQuantizedAndNormalizedComponents) {
  GlbDraft draft;
  const int normals =
      draft.add_accessor<std::int8_t>({0, 0, 127, 0, 0, 127, 0, 0, 0, -127, 0, 0}, kByte, "VEC3", 4);
  draft.json["accessors"][normals]["normalized"] = true;
  draft.json["bufferViews"].back()["byteStride"] = 4;
  const int uv = draft.add_accessor<std::uint16_t>({0, 65535, 65535, 0, 0, 0}, kUnsignedShort, "VEC2", 2);
  draft.json["accessors"][uv]["normalized"] = true;
  draft.json["extensionsRequired"] = draft.json["extensionsUsed"] = {"KHR_mesh_quantization"};
  primitive(draft)["attributes"]["NORMAL"] = normals;
  primitive(draft)["attributes"]["TEXCOORD_0"] = uv;
  const Mesh mesh = read(draft).meshes[0];
  EXPECT_EQ(mesh.normals, std::vector<Vec3>({{0, 0, 1}, {0, 1, 0}, {0, -1, 0}}));
  EXPECT_EQ(mesh.uv[0], std::vector<Vec2>({{0, 1}, {1, 0}, {0, 0}}));
}

TEST(Gltf, ReadsVertexColoursAsRgba) {
  GlbDraft draft;
  primitive(draft)["attributes"]["COLOR_0"] =
      draft.add_accessor<float>({1, 0, 0, 0, 0.5f, 0, 0, 0, 0.25f}, kFloat, "VEC3", 3);
  EXPECT_EQ(read(draft).meshes[0].colors, std::vector<Vec4>({{1, 0, 0, 1}, {0, 0.5f, 0, 1}, {0, 0, 0.25f, 1}}));
}

TEST(Gltf, CutsVertexColoursToWhatReflects) {
  GlbDraft draft;
  primitive(draft)["attributes"]["COLOR_0"] =
      draft.add_accessor<float>({1.5f, 0, 0, 0, -0.5f, 0, 0, 0, 1}, kFloat, "VEC3", 3);
  const Scene scene = read(draft);
  EXPECT_EQ(scene.meshes[0].colors, std::vector<Vec4>({{1, 0, 0, 1}, {0, 0, 0, 1}, {0, 0, 1, 1}}));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("COLOR_0 is cut to between 0 and 1")));
}

TEST(Gltf, AppliesSparseValues) {
  GlbDraft draft;
  const int indices = draft.add_accessor<std::uint8_t>({2, 0, 0, 0}, kUnsignedByte, "SCALAR", 4);
  const int values = draft.add_accessor<float>({0, 5, 0}, kFloat, "VEC3", 3);
  const int index_view = draft.json["accessors"][indices]["bufferView"];
  const int value_view = draft.json["accessors"][values]["bufferView"];
  draft.json["accessors"][0]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", index_view}, {"componentType", kUnsignedByte}}},
      {"values", {{"bufferView", value_view}}}};
  EXPECT_EQ(read(draft).meshes[0].positions[2], Vec3(0, 5, 0));
}

TEST(Gltf, AppliesMorphWeightsOfMeshAndNode) {
  GlbDraft draft;
  const int target = draft.add_accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3", 3);
  primitive(draft)["targets"] = json::array({{{"POSITION", target}}});
  draft.json["meshes"][0]["weights"] = {0.5};
  draft.json["nodes"] = json::array({{{"mesh", 0}}, {{"mesh", 0}, {"weights", {2}}}});
  draft.json["scenes"][0]["nodes"] = {0, 1};
  const Scene scene = read(draft);
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_FLOAT_EQ(scene.meshes[0].positions[0].z, 0.5f);
  EXPECT_FLOAT_EQ(scene.meshes[1].positions[0].z, 2);
}

TEST(Gltf, DropsAndCountsDegenerateTriangles) {
  GlbDraft draft;
  primitive(draft)["indices"] =
      draft.add_accessor<std::uint32_t>({0, 1, 2, 0, 1, 1, 2, 2, 2}, kUnsignedInt, "SCALAR", 1);
  const Scene scene = read(draft);
  EXPECT_EQ(scene.meshes[0].triangles.size(), 1u);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("2 degenerate triangles")));
}

TEST(Gltf, ReadsMaterialExtensions) {
  GlbDraft draft;
  draft.json["materials"] = json::array({json::parse(R"({
    "name": "m", "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true, "emissiveFactor": [1, 0.5, 0],
    "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.6},
    "extensions": {
      "KHR_materials_emissive_strength": {"emissiveStrength": 10},
      "KHR_materials_ior": {"ior": 1.33}, "KHR_materials_dispersion": {"dispersion": 0.1},
      "KHR_materials_specular": {"specularFactor": 0.7, "specularColorFactor": [1, 2, 3]},
      "KHR_materials_transmission": {"transmissionFactor": 0.8},
      "KHR_materials_volume": {"thicknessFactor": 2, "attenuationDistance": 3, "attenuationColor": [0.9, 0.8, 0.7]},
      "KHR_materials_anisotropy": {"anisotropyStrength": 0.6, "anisotropyRotation": 1.5},
      "KHR_materials_clearcoat": {"clearcoatFactor": 0.9, "clearcoatRoughnessFactor": 0.2},
      "KHR_materials_sheen": {"sheenColorFactor": [0.1, 0.2, 0.3], "sheenRoughnessFactor": 0.4},
      "KHR_materials_iridescence": {}}})")});
  primitive(draft)["material"] = 0;
  const Scene scene = read(draft);
  const Material& m = scene.materials[0];
  EXPECT_EQ(m.base_color, Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_FLOAT_EQ(m.alpha, 0.4f);
  EXPECT_FLOAT_EQ(m.metallic, 0.5f);
  EXPECT_FLOAT_EQ(m.roughness, 0.6f);
  EXPECT_EQ(m.emission, Rgb(10, 5, 0));
  EXPECT_EQ(m.alpha_mode, AlphaMode::mask);
  EXPECT_FLOAT_EQ(m.alpha_cutoff, 0.25f);
  EXPECT_TRUE(m.double_sided);
  EXPECT_FLOAT_EQ(m.ior, 1.33f);
  EXPECT_FLOAT_EQ(m.dispersion, 0.1f);
  EXPECT_FLOAT_EQ(m.specular, 0.7f);
  EXPECT_EQ(m.specular_color, Rgb(1, 2, 3));
  EXPECT_FLOAT_EQ(m.transmission, 0.8f);
  EXPECT_FALSE(m.thin_walled);
  EXPECT_FLOAT_EQ(m.attenuation_distance, 3);
  EXPECT_EQ(m.attenuation_color, Rgb(0.9f, 0.8f, 0.7f));
  EXPECT_FLOAT_EQ(m.anisotropy, 0.6f);
  EXPECT_FLOAT_EQ(m.anisotropy_rotation, 1.5f);
  EXPECT_FLOAT_EQ(m.clearcoat, 0.9f);
  EXPECT_FLOAT_EQ(m.clearcoat_roughness, 0.2f);
  EXPECT_EQ(m.sheen_color, Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_FLOAT_EQ(m.sheen_roughness, 0.4f);
  EXPECT_THAT(scene.warnings, Contains("materials[0]: KHR_materials_iridescence ignored"));
  EXPECT_THAT(scene.warnings, Contains("materials[0]: what a material emits is not dimmed by its clear coat"));
  EXPECT_FALSE(scene.environment.active());
}

TEST(Gltf, ReadsLightsInTheWorld) {
  GlbDraft draft;
  draft.json["extensionsUsed"] = {"KHR_lights_punctual"};
  draft.json["extensions"]["KHR_lights_punctual"]["lights"] =
      json::array({{{"type", "spot"},
                    {"color", {1, 0.5, 0}},
                    {"intensity", 8},
                    {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.6}}}},
                   {{"type", "directional"}},
                   {{"type", "point"}, {"name", "bulb"}}});
  const double half = std::sqrt(0.5);
  for (int light = 0; light < 3; ++light) {
    draft.json["nodes"].push_back({{"translation", {1, 2, 3}},
                                   {"rotation", {-half, 0, 0, half}},
                                   {"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
    draft.json["scenes"][0]["nodes"].push_back(light + 1);
  }
  const Scene scene = read(draft);
  ASSERT_EQ(scene.lights.size(), 3u);
  EXPECT_EQ(scene.lights[0].type, LightType::spot);
  EXPECT_EQ(scene.lights[0].intensity, Rgb(8, 4, 0));
  EXPECT_FLOAT_EQ(scene.lights[0].cos_inner, std::cos(0.1f));
  EXPECT_FLOAT_EQ(scene.lights[0].cos_outer, std::cos(0.6f));
  // −z turned by −90° about x shines down.
  EXPECT_LT(glm::length(scene.lights[0].direction - Vec3(0, -1, 0)), 1e-6f);
  EXPECT_EQ(scene.lights[1].type, LightType::directional);
  EXPECT_EQ(scene.lights[2].name, "bulb");
  EXPECT_EQ(scene.lights[2].position, Vec3(1, 2, 3));
  EXPECT_FALSE(scene.environment.active());
}

// A spot with a hard edge, as exporters write it.
TEST(Gltf, ReadsASpotWhoseConesAreOne) {
  GlbDraft draft;
  draft.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "spot"}, {"spot", {{"innerConeAngle", 0.5}, {"outerConeAngle", 0.5}}}}};
  draft.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  const Scene scene = read(draft);
  ASSERT_EQ(scene.lights.size(), 1u);
  const PunctualLight& spot = scene.lights[0];
  const auto beside = [&](float angle) {
    return spot.attenuation(Frame(spot.direction).to_world({std::sin(angle), 0, std::cos(angle)}));
  };
  EXPECT_EQ(beside(0.49f), 1);
  EXPECT_EQ(beside(0.51f), 0);
}

TEST(Gltf, TakesRoundingInTheLastRowOfAMatrix) {
  GlbDraft draft;
  draft.json["nodes"][0]["matrix"] = {2, 0, 0, 1e-9, 0, 2, 0, 0, 0, 0, 2, 0, 5, 6, 7, 0.99999994};
  EXPECT_EQ(read(draft).instances.at(0).to_world, Affine(2, 0, 0, 0, 2, 0, 0, 0, 2, 5, 6, 7));
}

// tinygltf keeps them in 32 bits only within extensions.
TEST(Gltf, ReadsLargeIntegersWhereTheyAreKept) {
  GlbDraft draft;
  draft.json["accessors"][0]["max"] = {4'294'967'295u, 1, 0};
  draft.json["nodes"][0]["translation"] = {6'378'137'000, 0, 0};
  draft.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 5'000'000'000}}};
  draft.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  const Scene scene = read(draft);
  EXPECT_EQ(scene.instances.at(0).to_world[3].x, 6'378'137'000.0f);
  EXPECT_EQ(scene.lights.at(0).intensity, Rgb(5e9f));
}

TEST(Gltf, IgnoresTangentsWithoutNormals) {
  GlbDraft draft;
  primitive(draft)["attributes"]["TANGENT"] =
      draft.add_accessor<float>({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}, kFloat, "VEC4", 4);
  EXPECT_TRUE(read(draft).meshes.at(0).tangents.empty());
  primitive(draft)["attributes"]["NORMAL"] = draft.add_accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3", 3);
  EXPECT_EQ(read(draft).meshes.at(0).tangents.size(), 3u);
}

// Scale 0 hides what hangs on a node; a light that shines to all sides needs no direction.
TEST(Gltf, LeavesOutCamerasAndLightsWithoutDirection) {
  GlbDraft draft;
  draft.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}}};
  draft.json["extensionsUsed"] = {"KHR_lights_punctual"};
  draft.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "directional"}}, {{"type", "point"}}};
  const auto light = [](int i) { return json{{"KHR_lights_punctual", {{"light", i}}}}; };
  const json hidden = {0, 0, 0}, flat = {1, 1, 0};
  draft.json["nodes"].push_back({{"camera", 0}, {"scale", hidden}});
  draft.json["nodes"].push_back({{"scale", hidden}, {"extensions", light(0)}});
  draft.json["nodes"].push_back({{"scale", flat}, {"translation", {1, 2, 3}}, {"extensions", light(1)}});
  draft.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
  const Scene scene = read(draft);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("leaves the camera no direction")));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("leaves the light no direction")));
  ASSERT_EQ(scene.cameras.size(), 1u);
  EXPECT_EQ(scene.cameras[0].name, "default");
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(scene.lights[0].position, Vec3(1, 2, 3));
}

TEST(Gltf, NamesCamerasAndMakesTheirFramesRigid) {
  GlbDraft draft;
  draft.json["cameras"] =
      json::array({{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}},
                   {{"type", "orthographic"},
                    {"name", "plan"},
                    {"orthographic", {{"xmag", 3}, {"ymag", 2}, {"znear", 0}, {"zfar", 10}}}}});
  draft.json["nodes"].push_back({{"camera", 0}, {"name", "from node"}, {"scale", {2, 3, 4}}});
  draft.json["nodes"].push_back({{"camera", 1}});
  draft.json["scenes"][0]["nodes"] = {0, 1, 2};
  const Scene scene = read(draft);
  ASSERT_EQ(scene.cameras.size(), 2u);
  EXPECT_EQ(scene.cameras[0].name, "from node");
  EXPECT_FLOAT_EQ(scene.cameras[0].yfov, 0.5f);
  EXPECT_EQ(scene.cameras[0].to_world, Affine(1));
  EXPECT_EQ(scene.cameras[1].name, "plan");
  EXPECT_TRUE(scene.cameras[1].orthographic);
  EXPECT_FLOAT_EQ(scene.cameras[1].ymag, 2);
}

TEST(Gltf, ReadsResourcesOfAJsonFileByCleanPath) {
  GlbDraft draft;
  json document = draft.json;
  document["buffers"] = json::array({{{"byteLength", draft.bin.size()}, {"uri", "./a%20b/./data.bin"}}});
  std::string asked;
  const ResourceReader reader = [&](const std::string& path) -> Result<std::vector<std::byte>> {
    asked = path;
    return test::bytes_of(draft.bin + "padding");
  };
  const Result<Scene> scene = read_gltf(test::bytes_of(document.dump()), reader);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(asked, "a b/data.bin");
}

TEST(Gltf, ReadsJsonBehindAByteOrderMark) {
  GlbDraft draft;
  json document = draft.json;
  document["buffers"] = json::array({{{"byteLength", draft.bin.size()}, {"uri", "data.bin"}}});
  const auto reader = [&](const std::string&) { return Result<std::vector<std::byte>>(test::bytes_of(draft.bin)); };
  const Result<Scene> scene = read_gltf(test::bytes_of("\xEF\xBB\xBF" + document.dump()), reader);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
}

TEST(Gltf, WarnsOfOptionalExtensions) {
  GlbDraft draft;
  draft.json["extensionsUsed"] = {"VENDOR_magic"};
  EXPECT_THAT(read(draft).warnings, Contains(HasSubstr("VENDOR_magic ignored")));
}

}  // namespace
}  // namespace photond
