#include "core/trace/touching.h"

#include <gtest/gtest.h>

#include "core/math/transform.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

Material liquid(float ior) {
  Material m = test::glass(ior);
  m.thin_walled = false;
  return m;
}

Material pane() {
  Material m = test::glass(1.5f);
  m.thin_walled = true;
  return m;
}

void add(Scene& scene, Mesh mesh, const Material& material) {
  test::add_mesh(scene, std::move(mesh), test::add_material(scene, material));
}

Bounds3 bounds(const Scene& scene, std::size_t instance) { return instance_bounds(scene)[instance]; }

// A block of glass as wide as 1 on a table of 4.
Scene block_on_table(float above) {
  Scene scene = test::empty_scene();
  add(scene, test::parallelogram({-2, 0, 2}, {4, 0, 0}, {0, 0, -4}), test::lambert(Rgb(0.5f)));
  add(scene, test::box({-0.5f, above, -0.5f}, {0.5f, 1 + above, 0.5f}), liquid(1.5f));
  return scene;
}

TEST(Touching, GlassOnATableIsLiftedALittle) {
  Scene scene = block_on_table(0);
  EXPECT_EQ(separate_touching(scene), 2u);
  EXPECT_GT(bounds(scene, 1).min.y, 8e-6f);
  EXPECT_LT(bounds(scene, 1).min.y, 3e-5f);
  EXPECT_EQ(bounds(scene, 1).max.y, 1);
  EXPECT_EQ(bounds(scene, 1).min.x, -0.5f);
  EXPECT_EQ(bounds(scene, 0).max.y, 0);
  const float lifted = bounds(scene, 1).min.y;
  EXPECT_EQ(separate_touching(scene), 0u) << "once is enough";
  EXPECT_EQ(bounds(scene, 1).min.y, lifted);
}

TEST(Touching, WhatDoesNotTouchStays) {
  for (const float above : {1e-3f, -1e-3f}) {
    Scene scene = block_on_table(above);
    EXPECT_EQ(separate_touching(scene), 0u) << above;
    EXPECT_EQ(bounds(scene, 1).min.y, above);
  }
  Scene opaque = block_on_table(0);
  opaque.materials[1] = test::lambert(Rgb(0.5f));
  EXPECT_EQ(separate_touching(opaque), 0u) << "no glass";
  Scene beside = test::empty_scene();   // an edge in common, and a corner
  add(beside, test::box({0, 0, 0}, {1, 1, 1}), liquid(1.5f));
  add(beside, test::parallelogram({1, 0, 0}, {1, 0, 0}, {0, 1, 0}), test::lambert(Rgb(1)));
  add(beside, test::parallelogram({1, 1, 1}, {1, 0, 0}, {0, 0, 1}), test::lambert(Rgb(1)));
  EXPECT_EQ(separate_touching(beside), 0u);
}

TEST(Touching, InACornerGlassKeepsAwayFromBothWalls) {
  Scene scene = block_on_table(0);
  add(scene, test::parallelogram({-0.5f, -1, 1}, {0, 0, -2}, {0, 3, 0}), test::lambert(Rgb(0.5f)));
  EXPECT_EQ(separate_touching(scene), 4u);
  EXPECT_GT(bounds(scene, 1).min.x, -0.5f + 8e-6f);
  EXPECT_GT(bounds(scene, 1).min.y, 8e-6f);
}

TEST(Touching, VolumesAreMovedIntoOneAnother) {
  Scene scene = test::empty_scene();
  add(scene, test::box({0, 0, 0}, {1, 1, 1}), liquid(1.5f));
  add(scene, test::box({0.3f, 1, 0.3f}, {2, 2, 2}), liquid(1.33f));   // no centre of a triangle is in another
  EXPECT_EQ(separate_touching(scene), 4u);
  EXPECT_GT(bounds(scene, 0).max.y, bounds(scene, 1).min.y + 1e-5f);
  EXPECT_LT(bounds(scene, 0).max.y, 1 + 3e-5f);
}

// A liquid that ends where the body around it does, and both look outwards: one of them only is moved.
TEST(Touching, NestedVolumesDoNotEndTogether) {
  Scene scene = test::empty_scene();
  add(scene, test::box({0, 0, 0}, {1, 1, 1}), liquid(1.5f));
  add(scene, test::box({0.2f, 0.5f, 0.2f}, {0.8f, 1, 0.8f}), liquid(1.33f));
  EXPECT_EQ(separate_touching(scene), 4u);
  EXPECT_GT(bounds(scene, 0).max.y, bounds(scene, 1).max.y + 5e-6f);
}

TEST(Touching, PanesLieOnTheFrontOfPictures) {
  for (const bool turned : {false, true}) {
    Scene scene = test::empty_scene();
    const Mesh sheet = test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    add(scene, sheet, test::lambert(Rgb(0.5f)));
    add(scene, turned ? test::inside_out(sheet) : sheet, pane());
    EXPECT_EQ(separate_touching(scene), 2u);
    EXPECT_GT(bounds(scene, 1).min.z, 2e-6f);
  }
}

// Placed many times: once by a table, turned, mirrored and as large as ten.
TEST(Touching, InstancesAreMovedAlike) {
  Scene scene = test::empty_scene();
  add(scene, test::parallelogram({-20, 0, 20}, {40, 0, 0}, {0, 0, -40}), test::lambert(Rgb(0.5f)));
  add(scene, test::box({0, 0, 0}, {1, 1, 1}), liquid(1.5f));
  scene.instances[1].to_world = Affine({10, 0, 0}, {0, 0, 10}, {0, 10, 0}, {0, 0, 0});   // mirrored, y up from z
  scene.instances.push_back({1, Affine({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {5, 3, 5})});
  EXPECT_EQ(separate_touching(scene), 2u);
  EXPECT_GT(bounds(scene, 1).min.y, 5e-5f);
  EXPECT_LT(bounds(scene, 1).min.y, 3e-4f);
  EXPECT_EQ(bounds(scene, 2).min.y, 3) << "its floor is another face";
}

// Equal spheres, one the hole in glass: every triangle touches, and no vertex tears away from its neighbours.
TEST(Touching, CurvedSurfacesStayClosed) {
  Scene scene = test::empty_scene();
  add(scene, test::inside_out(test::sphere({0, 0, 0}, 1, 16)), liquid(1.5f));
  add(scene, test::faceted(test::sphere({0, 0, 0}, 1, 16)), liquid(1.33f));
  const std::size_t triangles = scene.meshes[0].triangles.size();
  EXPECT_EQ(separate_touching(scene), 2 * triangles);
  for (const glm::uvec3& t : scene.meshes[0].triangles) {
    for (int i = 0; i < 3; ++i) {
      EXPECT_LT(glm::length(scene.meshes[0].positions[t[i]]), 1 - 4e-6f);
      EXPECT_GT(glm::length(scene.meshes[1].positions[t[i]]), 1 + 4e-6f);
    }
  }
}

}  // namespace
}  // namespace photond
