#include "core/trace/surface_boxes.h"

#include <gtest/gtest.h>

#include "core/math/rng.h"
#include "core/math/transform.h"
#include "core/math/warp.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

bool holds(const SurfaceBox& box, const Vec3& p) {
  const Vec3 margin(1e-5f);
  return glm::all(glm::greaterThanEqual(p, box.bounds.min - margin)) &&
         glm::all(glm::lessThanEqual(p, box.bounds.max + margin));
}

TEST(SurfaceBoxes, HoldEveryPointOfEverySurface) {
  const auto scene = test::busy_room();
  const auto boxes = surface_boxes(scene->scene, scene->bounds);
  Rng rng(1, RngPurpose::pilot, 0, 0);
  for (const Instance& instance : scene->scene.instances) {
    const Mesh& mesh = scene->scene.meshes[instance.mesh];
    for (int i = 0; i < 300; ++i) {
      const glm::uvec3& t = mesh.triangles[static_cast<std::size_t>(rng.next() * static_cast<float>(mesh.triangles.size()))];
      const Vec2 uv = square_to_triangle(rng.next2());
      const Vec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
      const Vec3 p = transform_point(instance.to_world, a + uv.x * (b - a) + uv.y * (c - a));
      EXPECT_TRUE(std::ranges::any_of(boxes, [&](const SurfaceBox& box) { return holds(box, p); }));
    }
  }
}

TEST(SurfaceBoxes, AreSmallAndHoldTheirCorners) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::parallelogram({0, 0, 0}, {32, 0, 0}, {0, 0, 32}),
                 test::add_material(scene, test::lambert(Rgb(1))));
  test::add_mesh(scene, test::sphere({20, 16, 5}, 3), 0);
  const Bounds3 bounds = world_bounds(scene);
  const auto boxes = surface_boxes(scene, bounds);
  EXPECT_GT(boxes.size(), 1000u);
  EXPECT_LT(boxes.size(), 2000u);
  for (const SurfaceBox& box : boxes) {
    EXPECT_LE(max_component(box.bounds.extent()), 1.51f);   // a cell and what sticks out of it on both sides
    for (const Vec3& corner : box.corners) EXPECT_TRUE(holds(box, corner));
  }
}

TEST(SurfaceBoxes, OfNothingAreNone) {
  const Scene scene = test::empty_scene();
  EXPECT_TRUE(surface_boxes(scene, world_bounds(scene)).empty());
}

// All triangles in one point, and one that is long and thin.
TEST(SurfaceBoxes, StandDegenerateTriangles) {
  Scene scene = test::empty_scene();
  Mesh mesh;
  mesh.positions = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  mesh.triangles = {{0, 1, 2}};
  test::add_mesh(scene, mesh, test::add_material(scene, test::lambert(Rgb(1))));
  ASSERT_EQ(surface_boxes(scene, world_bounds(scene)).size(), 1u);
  mesh.positions = {{0, 0, 0}, {1e6f, 1e-30f, 0}, {1e6f, 0, 1e-30f}};
  test::add_mesh(scene, mesh, 0);
  const auto boxes = surface_boxes(scene, world_bounds(scene));
  EXPECT_GE(boxes.size(), 32u);
}

}  // namespace
}  // namespace photond
