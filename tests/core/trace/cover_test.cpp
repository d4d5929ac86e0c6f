#include "core/trace/cover.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "core/math/transform.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

bool contains(const Bounds3& box, const Vec3& p) {
  return glm::all(glm::lessThanEqual(box.min, p)) && glm::all(glm::lessThanEqual(p, box.max));
}

// Of all its corners one part, or the whole where there are none.
bool contains(const Cover& cover, const Vec3 (&triangle)[3]) {
  const auto all = [&](const Bounds3& box) {
    return contains(box, triangle[0]) && contains(box, triangle[1]) && contains(box, triangle[2]);
  };
  return all(cover.whole) && (cover.parts.empty() || std::ranges::any_of(cover.parts, all));
}

// Two spheres far apart, one of them moved there, and a wall.
Scene spheres() {
  Scene scene = test::empty_scene();
  const std::uint32_t material = test::add_material(scene, test::lambert(Rgb(0.5f)));
  test::add_mesh(scene, test::sphere({0, 0, 0}, 1), material);
  scene.instances.push_back(scene.instances[0]);
  scene.instances[1].to_world[3] = {9, 4, -7};
  scene.instances[1].moved = true;
  test::add_mesh(scene, test::box({-20, -20, -20}, {20, 20, 20}), material);
  return scene;
}

TEST(Cover, HoldsEveryTriangle) {
  const Scene scene = spheres();
  const std::uint32_t both[] = {0, 1};
  const Cover c = cover(scene, both);
  EXPECT_GT(c.parts.size(), 2u);
  EXPECT_LE(c.parts.size(), kCoverParts);
  EXPECT_FALSE(contains(c.whole, {20, 20, 20}));   // the wall is not asked for
  for (const std::uint32_t i : both) {
    const Instance& instance = scene.instances[i];
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const glm::uvec3& t : mesh.triangles) {
      Vec3 triangle[3];
      for (int k = 0; k < 3; ++k) triangle[k] = transform_point(instance.to_world, mesh.positions[t[k]]);
      ASSERT_TRUE(contains(c, triangle));
    }
  }
}

TEST(Cover, HasNoPartsWhereTheyKeepFewRaysAway) {
  Scene scene = spheres();
  EXPECT_TRUE(cover(scene, std::array{2u}).parts.empty());
  EXPECT_TRUE(cover(scene, {}).whole.empty());
  EXPECT_TRUE(cover(scene, {}).parts.empty());
}

TEST(Cover, OfVeryManyTrianglesIsOfInstances) {
  Scene scene = spheres();
  std::vector<glm::uvec3>& triangles = scene.meshes[0].triangles;
  const std::vector<glm::uvec3> once = triangles;
  while (triangles.size() <= 1u << 16) triangles.insert(triangles.end(), once.begin(), once.end());
  EXPECT_EQ(cover(scene, std::array{0u, 1u}).parts.size(), 2u);
}

TEST(Cover, IsCrossedByLinesInProportionToItsSurface) {
  const Bounds3 world{{-1, 0, 2}, {2, 2, 3}};                    // half its surface: 6 + 2 + 3
  const Bounds3 a{{-0.5f, 0.2f, 2.1f}, {0.5f, 1.2f, 2.6f}};      // 1 + 0.5 + 0.5
  EXPECT_NEAR(crossing_share({a, {}}, world), 2.0 / 11, 0.02);
  EXPECT_NEAR(crossing_share({a, {a, a}}, world), 2.0 / 11, 0.02);
  EXPECT_EQ(crossing_share({world, {}}, world), 1);
  EXPECT_EQ(crossing_share({}, world), 0);
  EXPECT_EQ(crossing_share({}, {}), 0);
}

}  // namespace
}  // namespace photond
