#include "core/trace/overlap.h"

#include <gtest/gtest.h>

#include "tests/support/scenes.h"

namespace photond {
namespace {

// A sphere in a cube of side 2 around each of the points.
Scene spheres(std::initializer_list<Vec3> centers) {
  Scene scene = test::empty_scene();
  const std::uint32_t material = test::add_material(scene, test::lambert(Rgb(0.5f)));
  for (const Vec3& center : centers) test::add_mesh(scene, test::sphere(center, 1), material);
  return scene;
}

TEST(Overlap, IsNoneOfObjectsThatLieApart) {
  EXPECT_EQ(overlap(test::empty_scene()), 0);
  EXPECT_EQ(overlap(spheres({{0, 0, 0}})), 0);
  EXPECT_EQ(overlap(spheres({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}})), 0);
}

TEST(Overlap, CountsPairsWhereTheLinesPass) {
  EXPECT_NEAR(overlap(spheres({{0, 0, 0}, {0, 0, 0}})), 1, 1e-5f);
  EXPECT_NEAR(overlap(spheres({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}})), 3, 1e-5f);
  // A box of 1 × 2 × 2 in one of 3 × 2 × 2: surfaces of 16 and 32.
  EXPECT_NEAR(overlap(spheres({{0, 0, 0}, {1, 0, 0}})), 0.5f, 1e-3f);
}

TEST(Overlap, GoesWithTheInstances) {
  Scene scene = spheres({{0, 0, 0}});
  scene.instances.push_back(scene.instances[0]);
  EXPECT_NEAR(overlap(scene), 1, 1e-5f);
  scene.instances[1].to_world[3] = {5, 0, 0};
  EXPECT_EQ(overlap(scene), 0);
}

TEST(Overlap, LeavesOutMeshesOfAFewTriangles) {
  Scene scene = spheres({{0, 0, 0}});
  test::add_mesh(scene, test::box({-1, -1, -1}, {1, 1, 1}), 0);
  EXPECT_EQ(overlap(scene), 0);
}

TEST(Overlap, OfTooManyInstancesIsUnknown) {
  Scene scene = spheres({{0, 0, 0}});
  scene.instances.resize(2049, scene.instances[0]);
  EXPECT_EQ(overlap(scene), kInfinity);
}

}  // namespace
}  // namespace photond
