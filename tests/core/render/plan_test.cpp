#include "core/render/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

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

/// A floor of metal under a lamp, and perhaps a ball of glass.
Plan plan_of_gloss(Method method, float roughness, bool glass) {
  Scene scene = test::empty_scene();
  Material metal = test::mirror(Rgb(0.5f));
  metal.roughness = roughness;
  test::add_mesh(scene, test::parallelogram({-1, 0, -1}, {0, 0, 2}, {2, 0, 0}), test::add_material(scene, metal));
  if (glass) test::add_mesh(scene, test::sphere({0, 1, 0}, 0.5f, 8), test::add_material(scene, test::glass(1.5f)));
  test::add_point_light(scene, {0, 3, 0}, Rgb(1));
  const auto plan = make_plan(*test::prepared(std::move(scene)), {.method = method}, Execution{});
  EXPECT_TRUE(plan.ok());
  return *plan;
}

bool merges_on_gloss(const Plan& plan) {
  for (const PlanItem& item : plan.items) {
    if (item.feature == "gloss_merge") return item.active;
  }
  ADD_FAILURE() << "not told";
  return false;
}

TEST(Plan, TellsThatDirectedPathsAreFewer) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::parallelogram({-1, 0, -1}, {0, 0, 2}, {2, 0, 0}),
                 test::add_material(scene, test::lambert(Rgb(0.5f))));
  test::add_mesh(scene, test::parallelogram({0, 5, 0}, {0.1f, 0, 0}, {0, 0, 0.1f}),
                 test::add_material(scene, test::emitter(Rgb(1))));
  const auto prepared = test::prepared(scene);
  const auto of = [&](Method method, const char* feature) {
    const auto plan = make_plan(*prepared, {.method = method}, Execution{});
    for (const PlanItem& item : plan->items) {
      if (item.feature == feature) return item;
    }
    return PlanItem{};
  };
  EXPECT_TRUE(of(Method::progressive, "emission_domain").active);
  EXPECT_THAT(of(Method::progressive, "emission_domain").reason, HasSubstr("of the paths that leave lamps meet a surface"));
  EXPECT_TRUE(of(Method::progressive, "fewer_paths").active);
  EXPECT_THAT(of(Method::progressive, "fewer_paths").reason, HasSubstr("as many are traced in a pass"));
  EXPECT_FALSE(of(Method::path, "emission_domain").active);
  EXPECT_FALSE(of(Method::path, "fewer_paths").active);
}

TEST(Plan, TellsOfLampsWithPictures) {
  const auto item_of = [](std::vector<std::uint8_t> texels) {
    Scene scene = test::empty_scene();
    scene.images.push_back({.width = 2, .height = 1, .u8 = std::move(texels)});
    scene.textures.push_back({.nearest = true});
    Material picture = test::emitter(Rgb(1));
    picture.emission_texture.texture = 0;
    test::add_mesh(scene, test::parallelogram({0, 5, 0}, {1, 0, 0}, {0, 0, 1}), test::add_material(scene, picture));
    const auto plan = make_plan(*test::prepared(std::move(scene)), {.method = Method::path}, Execution{});
    for (const PlanItem& item : plan->items) {
      if (item.feature == "emission_pattern") return item;
    }
    return PlanItem{};
  };
  const PlanItem even = item_of({255, 255, 255, 255, 255, 255, 255, 255});
  EXPECT_FALSE(even.active);
  EXPECT_THAT(even.reason, HasSubstr("evenly"));
  const PlanItem uneven = item_of({255, 255, 255, 255, 0, 0, 0, 255});
  EXPECT_TRUE(uneven.active);
  EXPECT_THAT(uneven.reason, HasSubstr("2 of 2 triangles"));
}

// Light of points that a smooth coat reflects, paths never find.
TEST(Plan, PhotonsCarryWhatCoatsMirrorOfPoints) {
  const auto of_coat = [](float roughness, bool point) {
    Scene scene = test::empty_scene();
    Material coat = test::lambert(Rgb(0.5f));
    coat.specular = 1;
    coat.roughness = roughness;
    test::add_mesh(scene, test::parallelogram({-1, 0, -1}, {0, 0, 2}, {2, 0, 0}), test::add_material(scene, coat));
    test::add_mesh(scene, test::parallelogram({0, 3, 0}, {1, 0, 0}, {0, 0, 1}), test::add_material(scene, test::emitter(Rgb(1))));
    if (point) test::add_point_light(scene, {0, 2, 0}, Rgb(1));
    return make_plan(*test::prepared(std::move(scene)), {.method = Method::hybrid}, Execution{})->uses_maps;
  };
  EXPECT_TRUE(of_coat(0, true));
  EXPECT_FALSE(of_coat(0, false));
  EXPECT_FALSE(of_coat(0.3f, true));
}

// Even polished metal gathers below fibres.
TEST(Plan, TellsOfSheen) {
  for (const bool sheen : {false, true}) {
    Scene scene = test::empty_scene();
    Material metal = test::mirror(Rgb(0.5f));
    if (sheen) metal.sheen_color = Rgb(0, 0.5f, 0);
    test::add_mesh(scene, test::parallelogram({-1, 0, -1}, {0, 0, 2}, {2, 0, 0}), test::add_material(scene, metal));
    test::add_point_light(scene, {0, 2, 0}, Rgb(1));
    const auto plan = make_plan(*test::prepared(std::move(scene)), {.method = Method::hybrid}, Execution{});
    EXPECT_EQ(plan->uses_maps, sheen);
    const auto item = std::ranges::find(plan->items, "sheen", &PlanItem::feature);
    ASSERT_NE(item, plan->items.end());
    EXPECT_EQ(item->active, sheen);
  }
}

TEST(Plan, NamesWhatIsBrushed) {
  for (const bool brushed : {false, true}) {
    Scene scene = test::empty_scene();
    Material metal = test::mirror(Rgb(0.5f));
    metal.anisotropy = brushed ? 0.5f : 0;
    test::add_mesh(scene, test::parallelogram({-1, 0, -1}, {0, 0, 2}, {2, 0, 0}), test::add_material(scene, metal));
    const auto plan = make_plan(*test::prepared(std::move(scene)), {}, Execution{});
    const auto item = std::ranges::find(plan->items, "anisotropy", &PlanItem::feature);
    ASSERT_NE(item, plan->items.end());
    EXPECT_EQ(item->active, brushed);
  }
}

TEST(Plan, SharesAreWrittenOutInFull) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::box({-1, -1, -1}, {1, 1, 1}, true), test::add_material(scene, test::emitter(Rgb(1))));
  const auto plan = make_plan(*test::prepared(scene), {.method = Method::progressive}, Execution{});
  for (const PlanItem& item : plan->items) {
    if (item.feature != "emission_domain") continue;
    EXPECT_EQ(item.reason, "100 % of the paths that leave lamps meet a surface; 100 % go where they may");
    return;
  }
  ADD_FAILURE() << "not told";
}

TEST(Plan, GathersOnGlossWhereItIsLitThroughGlass) {
  const Plan plan = plan_of_gloss(Method::automatic, 0.4f, true);
  EXPECT_EQ(plan.method, Method::progressive);   // paths would not find the point
  EXPECT_TRUE(merges_on_gloss(plan));
  EXPECT_TRUE(merges_on_gloss(plan_of_gloss(Method::hybrid, 0.4f, true)));
  EXPECT_FALSE(merges_on_gloss(plan_of_gloss(Method::progressive, 0.4f, false)));
  EXPECT_FALSE(merges_on_gloss(plan_of_gloss(Method::progressive, 0, true)));      // a mirror
  EXPECT_FALSE(merges_on_gloss(plan_of_gloss(Method::progressive, 0.8f, true)));   // all photons are gathered there
  EXPECT_FALSE(merges_on_gloss(plan_of_gloss(Method::path, 0.4f, true)));
  EXPECT_FALSE(merges_on_gloss(plan_of_gloss(Method::photon_map, 0.4f, true)));
}

}  // namespace
}  // namespace photond
