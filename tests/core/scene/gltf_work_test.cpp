// Small files that ask for much work: it stays in proportion to the file, or is refused beforehand.
#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <string>

#include "core/scene/gltf.h"
#include "tests/support/glb.h"

namespace photond {
namespace {

using nlohmann::json;
using test::GlbDraft;

constexpr int kFloat = 5126;

json& primitive(GlbDraft& draft) { return draft.json["meshes"][0]["primitives"][0]; }

/// Seconds that reading takes. The file must be read.
double seconds_to_read(const GlbDraft& draft, Scene* scene = nullptr) {
  const std::vector<std::byte> bytes = draft.pack();
  const auto start = std::chrono::steady_clock::now();
  Result<Scene> read = read_gltf(bytes, no_resources());
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  EXPECT_TRUE(read.ok()) << read.error().where << ": " << read.error().message;
  if (read && scene != nullptr) *scene = std::move(*read);
  return taken.count();
}

Error refusal(const GlbDraft& draft, const SceneLimits& limits) {
  const Result<Scene> scene = read_gltf(draft.pack(), no_resources(), limits);
  EXPECT_FALSE(scene.ok());
  return scene ? Error{} : scene.error();
}

// Ten seconds and more where each is compared with all others; a fifth of one otherwise.
constexpr double kLinear = 4;

TEST(GltfWork, ManyCamerasGetNamesOfTheirOwn) {
  constexpr std::size_t kCameras = 60'000;
  GlbDraft draft;
  draft.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}}};
  // The second half has no names, and the first has those that come first to mind.
  for (std::size_t i = 0; i < kCameras; ++i) {
    draft.json["nodes"].push_back({{"camera", 0}});
    if (i < kCameras / 2) draft.json["nodes"].back()["name"] = "camera " + std::to_string(i + kCameras / 2);
    draft.json["scenes"][0]["nodes"].push_back(i + 1);
  }
  Scene scene;
  EXPECT_LT(seconds_to_read(draft, &scene), kLinear);
  ASSERT_EQ(scene.cameras.size(), kCameras);
  std::set<std::string> names;
  for (const Camera& camera : scene.cameras) names.insert(camera.name);
  EXPECT_EQ(names.size(), kCameras);
}

TEST(GltfWork, ManyAttributesAreNotComparedWithEachOther) {
  GlbDraft draft;
  for (int i = 0; i < 20'000; ++i) primitive(draft)["attributes"]["_" + std::to_string(i)] = 0;
  EXPECT_LT(seconds_to_read(draft), kLinear);
}

// Each is added to every vertex.
TEST(GltfWork, MorphTargetsCountAsVertices) {
  GlbDraft draft;
  const int target = draft.add_accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3", 3);
  const json morph = {{"POSITION", target}};
  primitive(draft)["targets"] = {morph, morph, morph};
  draft.json["meshes"][0]["weights"] = {1, 0, 1};
  EXPECT_TRUE(read_gltf(draft.pack(), no_resources(), {.max_vertices = 9}).ok()) << "one of them is not added";
  const Error error = refusal(draft, {.max_vertices = 8});
  EXPECT_EQ(error.code, ErrorCode::limit_exceeded);
  EXPECT_EQ(error.where, "meshes[0].primitives[0]");
}

// A mesh of points alone has nothing to place, nor has one that is flattened; their places would be read all the same.
TEST(GltfWork, PlacesOfNothingCountAsInstances) {
  GlbDraft draft;
  const int places = draft.add_accessor<float>({0, 0, 0, 5, 6, 7}, kFloat, "VEC3", 3);
  json points = draft.json["meshes"][0];
  points["primitives"][0]["mode"] = 0;
  draft.json["meshes"].push_back(points);
  const json placed = {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", places}}}}}};
  for (int i = 1; i <= 3; ++i) {
    draft.json["nodes"].push_back({{"mesh", 1}, {"extensions", placed}});
    draft.json["scenes"][0]["nodes"].push_back(i);
  }
  EXPECT_TRUE(read_gltf(draft.pack(), no_resources(), {.max_instances = 6}).ok());
  EXPECT_EQ(refusal(draft, {.max_instances = 5}).where, "nodes[3]");
}

}  // namespace
}  // namespace photond
