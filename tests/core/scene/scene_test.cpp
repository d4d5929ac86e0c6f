#include "core/scene/scene.h"

#include <gtest/gtest.h>

#include <functional>

#include "core/scene/report.h"

namespace photond {
namespace {

Scene small_scene() {
  Scene scene;
  scene.materials.push_back({.name = "plain"});
  scene.meshes.push_back(
      {.name = "triangle", .positions = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}}, .triangles = {{0, 1, 2}}});
  scene.instances.push_back({0, Affine(1)});
  scene.lights.push_back({.name = "lamp"});
  scene.cameras.push_back({.name = "main"});
  return scene;
}

TEST(SceneDigest, IgnoresWhatDoesNotChangeThePhotons) {
  const Digest digest = scene_digest(small_scene());
  const std::function<void(Scene&)> changes[] = {
      [](Scene& s) { s.cameras[0].yfov = 1; },      [](Scene& s) { s.cameras.clear(); },
      [](Scene& s) { s.meshes[0].name = "other"; }, [](Scene& s) { s.materials[0].name = "other"; },
      [](Scene& s) { s.lights[0].name = "other"; }, [](Scene& s) { s.warnings.push_back("careful"); }};
  for (const auto& change : changes) {
    Scene scene = small_scene();
    change(scene);
    EXPECT_EQ(scene_digest(scene), digest);
  }
}

TEST(SceneDigest, NoticesWhatChangesThePhotons) {
  const Digest digest = scene_digest(small_scene());
  const std::function<void(Scene&)> changes[] = {
      [](Scene& s) { s.meshes[0].positions[2].y = 2.000001f; },
      [](Scene& s) {
        s.meshes[0].triangles[0] = {0, 2, 1};
      },
      [](Scene& s) { s.meshes[0].normals.assign(3, Vec3(0, 0, 1)); },
      [](Scene& s) { s.meshes[0].uv[0].assign(3, Vec2(0)); },
      [](Scene& s) { s.instances[0].to_world[3].x = 1; },
      [](Scene& s) { s.materials[0].base_color.g = 0.9f; },
      [](Scene& s) { s.materials[0].thin_walled = false; },
      [](Scene& s) { s.materials[0].normal_texture.uv_set = 1; },
      [](Scene& s) { s.lights[0].intensity.b = 2; },
      [](Scene& s) { s.environment.radiance = Rgb(0.1f); },
      [](Scene& s) {
        s.images.push_back({.width = 1, .height = 1, .u8 = {1, 2, 3, 4}});
      },
      [](Scene& s) { s.textures.push_back({}); }};
  std::vector<Digest> seen = {digest};
  for (const auto& change : changes) {
    Scene scene = small_scene();
    change(scene);
    const Digest changed = scene_digest(scene);
    for (const Digest& other : seen) EXPECT_NE(changed, other);
    seen.push_back(changed);
  }
  // uv in set 0 and the same in set 1 are different scenes.
  Scene second_set = small_scene();
  second_set.meshes[0].uv[1].assign(3, Vec2(0));
  for (const Digest& other : seen) EXPECT_NE(scene_digest(second_set), other);
}

TEST(Scene, BoundsFollowTheInstances) {
  Scene scene = small_scene();
  scene.instances[0].to_world[3] = {10, 0, 0};
  scene.meshes[0].positions.push_back({100, 100, 100});  // used by no triangle
  const Bounds3 bounds = world_bounds(scene);
  EXPECT_EQ(bounds.min, Vec3(10, 0, 0));
  EXPECT_EQ(bounds.max, Vec3(11, 2, 0));
}

TEST(SceneReport, CountsAndNames) {
  Scene scene = small_scene();
  scene.materials.push_back({.name = "glow", .emission = Rgb(2)});
  scene.meshes.push_back(scene.meshes[0]);
  scene.meshes[1].material = 1;
  scene.instances.push_back({1, Affine(1)});
  scene.instances.push_back({1, Affine(1)});
  scene.warnings = {"something"};
  const SceneReport report = make_report(scene);
  EXPECT_EQ(report.meshes, 2u);
  EXPECT_EQ(report.instances, 3u);
  EXPECT_EQ(report.triangles_stored, 2u);
  EXPECT_EQ(report.triangles_placed, 3u);
  EXPECT_EQ(report.emissive_triangles, 2u);
  EXPECT_EQ(report.cameras.at(0).name, "main");
  EXPECT_TRUE(report.materials.at(1).emissive);
  EXPECT_EQ(report.warnings, scene.warnings);
}

TEST(SceneReport, NamesKindsOfMaterial) {
  EXPECT_EQ(material_kind({.metallic = 0, .specular = 0}), "diffuse");
  EXPECT_EQ(material_kind({.metallic = 0}), "glossy");
  EXPECT_EQ(material_kind({.metallic = 1, .roughness = 0}), "mirror");
  EXPECT_EQ(material_kind({.metallic = 1, .roughness = 0.3f}), "metal");
  EXPECT_EQ(material_kind({.metallic = 0, .roughness = 0, .transmission = 1, .thin_walled = false}), "glass");
  EXPECT_EQ(material_kind({.metallic = 0, .roughness = 0.2f, .transmission = 1, .thin_walled = false}),
            "frosted glass");
  EXPECT_EQ(material_kind({.metallic = 0, .transmission = 1}), "thin glass");
}

}  // namespace
}  // namespace photond
