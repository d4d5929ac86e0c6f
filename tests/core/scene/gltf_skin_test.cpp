// Skins: meshes that follow the nodes which are their joints.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/scene/gltf.h"
#include "tests/support/glb.h"

namespace photond {
namespace {

using nlohmann::json;
using test::GlbDraft;
using testing::Contains;
using testing::HasSubstr;

constexpr int kUnsignedByte = 5121, kFloat = 5126;

/// The triangle (0,0,0), (1,0,0), (0,1,0) whose vertices follow joint 0, joint 1, and both by halves. Joint 0 is moved
/// by (10,0,0), joint 1 hangs on it and is scaled by 2; the mesh was modelled around (0,0,1) of joint 0.
GlbDraft skinned_triangle() {
  GlbDraft draft;
  json& attributes = draft.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["NORMAL"] = draft.add_accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3", 3);
  attributes["JOINTS_0"] =
      draft.add_accessor<std::uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 9, 0}, kUnsignedByte, "VEC4", 4);
  attributes["WEIGHTS_0"] = draft.add_accessor<float>({1, 0, 0, 0, 2, 0, 0, 0, 0.5f, 0.5f, 0, 0}, kFloat, "VEC4", 4);
  const int inverse_bind = draft.add_accessor<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 1,  //
                                                      1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
                                                     kFloat, "MAT4", 16);
  draft.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", inverse_bind}}};
  draft.json["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {0, 500, 0}}},
                         {{"translation", {10, 0, 0}}, {"children", {2}}},
                         {{"scale", {2, 2, 2}}}};
  draft.json["scenes"][0]["nodes"] = {0, 1};
  return draft;
}

Error refusal(const GlbDraft& draft, const SceneLimits& limits = {}) {
  const Result<Scene> scene = read_gltf(draft.pack(), no_resources(), limits);
  EXPECT_FALSE(scene.ok());
  return scene ? Error{} : scene.error();
}

TEST(GltfSkin, VerticesFollowTheirJointsAndNotTheNode) {
  const Result<Scene> scene = read_gltf(skinned_triangle().pack(), no_resources());
  ASSERT_TRUE(scene.ok()) << scene.error().where << ": " << scene.error().message;
  ASSERT_EQ(scene->instances.size(), 1u);
  EXPECT_EQ(scene->instances[0].to_world, Affine(1)) << "glTF: the node's transform is ignored";
  const Mesh& mesh = scene->meshes.at(0);
  EXPECT_EQ(mesh.positions[0], Vec3(10, 0, -1));
  EXPECT_EQ(mesh.positions[1], Vec3(12, 0, 0)) << "weights of sum 2 are made 1";
  EXPECT_EQ(mesh.positions[2], Vec3(10, 1.5f, -0.5f)) << "a joint of weight 0 does not matter";
  for (const Vec3& normal : mesh.normals) EXPECT_EQ(normal, Vec3(0, 0, 1));
  EXPECT_THAT(scene->warnings, Not(Contains(HasSubstr("skin"))));
}

TEST(GltfSkin, NormalsAndTangentsAreTurned) {
  GlbDraft draft = skinned_triangle();
  draft.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] =
      draft.add_accessor<float>({1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, -1}, kFloat, "VEC4", 4);
  const double half = std::sqrt(0.5);
  draft.json["nodes"][1]["rotation"] = {0, half, 0, half};  // +Z to +X, +X to −Z
  const Result<Scene> scene = read_gltf(draft.pack(), no_resources());
  ASSERT_TRUE(scene.ok()) << scene.error().where << ": " << scene.error().message;
  for (const Vec3& normal : scene->meshes.at(0).normals) EXPECT_LT(glm::length(normal - Vec3(1, 0, 0)), 1e-6f);
  for (const Vec4& tangent : scene->meshes.at(0).tangents) EXPECT_LT(glm::length(tangent - Vec4(0, 0, -1, -1)), 1e-6f);
}

// The same mesh under another skin is another mesh.
TEST(GltfSkin, MeshesAreSharedBySkin) {
  GlbDraft draft = skinned_triangle();
  draft.json["skins"].push_back({{"joints", {2, 1}}});
  for (int skin : {1, 1, -1}) {
    json node = {{"mesh", 0}};
    if (skin >= 0) node["skin"] = skin;
    draft.json["scenes"][0]["nodes"].push_back(draft.json["nodes"].size());
    draft.json["nodes"].push_back(node);
  }
  const Result<Scene> scene = read_gltf(draft.pack(), no_resources());
  ASSERT_TRUE(scene.ok()) << scene.error().where << ": " << scene.error().message;
  EXPECT_EQ(scene->instances.size(), 4u);
  ASSERT_EQ(scene->meshes.size(), 3u);
  EXPECT_EQ(scene->meshes[1].positions[1], Vec3(11, 0, 0)) << "no inverse bind matrices: the identity";
  EXPECT_EQ(scene->meshes[2].positions[1], Vec3(1, 0, 0));
}

TEST(GltfSkin, WarnsWhereTheMeshHasNoJoints) {
  GlbDraft draft = skinned_triangle();
  draft.json["meshes"][0]["primitives"][0]["attributes"].erase("JOINTS_0");
  const Result<Scene> scene = read_gltf(draft.pack(), no_resources());
  ASSERT_TRUE(scene.ok()) << scene.error().where << ": " << scene.error().message;
  EXPECT_EQ(scene->instances.at(0).to_world[3], Vec3(0, 500, 0));
  EXPECT_THAT(scene->warnings, Contains(HasSubstr("nodes[0]: skin")));
}

TEST(GltfSkin, RefusesBrokenSkinsWithTheirPlace) {
  const auto where = [](const char* pointer, const json& value) {
    GlbDraft draft = skinned_triangle();
    draft.json[json::json_pointer(pointer)] = value;
    return refusal(draft).where;
  };
  EXPECT_EQ(where("/skins/0/joints/1", 3), "skins[0].joints[1]");
  EXPECT_EQ(where("/skins/0/joints", json::array()), "skins[0].joints");
  EXPECT_EQ(where("/skins/0/joints", {1}), "meshes[0].primitives[0].attributes.JOINTS_0");
  EXPECT_EQ(where("/skins/0/joints", {1, 2, 0}), "skins[0].inverseBindMatrices") << "of two joints only";
  EXPECT_EQ(where("/skins/0/inverseBindMatrices", 0), "skins[0].inverseBindMatrices");
  EXPECT_EQ(where("/nodes/2/scale", {1e16, 1e16, 1e16}), "meshes[0].primitives[0]") << "absurdly far";
}

// Of the inverse bind matrices there may be more than joints.
TEST(GltfSkin, MatricesCountAsFourVertices) {
  GlbDraft draft = skinned_triangle();
  EXPECT_TRUE(read_gltf(draft.pack(), no_resources(), {.max_vertices = 3 + 4 * 2}).ok());
  EXPECT_EQ(refusal(draft, {.max_vertices = 3 + 4 * 2 - 1}).code, ErrorCode::limit_exceeded);
  draft.json["accessors"].push_back({{"componentType", kFloat}, {"count", 100}, {"type", "MAT4"}});
  draft.json["skins"][0]["inverseBindMatrices"] = draft.json["accessors"].size() - 1;
  EXPECT_EQ(refusal(draft, {.max_vertices = 4 * 100 - 1}).where, "skins[0]");
}

}  // namespace
}  // namespace photond
