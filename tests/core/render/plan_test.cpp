#include "core/render/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scenes.h"

namespace photond {
namespace {

using ::testing::HasSubstr;

/// A floor, perhaps with a ball of glass above it, under a lamp or a dull sky.
std::string caustics_by_path(bool glass, bool lamp) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::parallelogram({-1, 0, -1}, {0, 0, 2}, {2, 0, 0}),
                 test::add_material(scene, test::lambert(Rgb(0.5f))));
  if (glass) test::add_mesh(scene, test::sphere({0, 1, 0}, 0.5f, 8), test::add_material(scene, test::glass(1.5f)));
  if (lamp) test::add_point_light(scene, {0, 3, 0}, Rgb(1));
  scene.environment.radiance = Rgb(0.2f);
  const auto plan = make_plan(*test::prepared(std::move(scene)), {.method = Method::path}, Execution{});
  EXPECT_TRUE(plan.ok());
  for (const PlanItem& item : plan->items) {
    if (item.feature == "caustic_map") return item.reason;
  }
  return {};
}

TEST(Plan, TellsWhatPathsMayNotFind) {
  EXPECT_THAT(caustics_by_path(true, true), HasSubstr("transmits light: what paths have not found of that light is missing"));
  EXPECT_EQ(caustics_by_path(true, false), "the method stores no photons");
  EXPECT_EQ(caustics_by_path(false, true), "no material bundles light");
}

}  // namespace
}  // namespace photond
