#include "core/render/render.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/support/scenes.h"

namespace photond {
namespace {

TEST(RenderPass, BitsDoNotDependOnTheThreads) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::box({-1, -1, -1}, {1, 1, 6}, true),
                 test::add_material(scene, test::lambert({0.7f, 0.5f, 0.4f})));
  test::add_mesh(scene, test::sphere({0, -0.4f, 0}, 0.5f), test::add_material(scene, test::glass(1.5f)));
  test::add_mesh(scene, test::parallelogram({-0.3f, 0.9f, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}),
                 test::add_material(scene, test::emitter(Rgb(10))));
  const auto prepared = test::prepared(std::move(scene));
  PhotonSettings photons;
  photons.photons_per_pass = 30'000;
  for (const Method method : {Method::path, Method::photon_map, Method::progressive, Method::hybrid}) {
    RenderSettings settings;
    settings.method = method;
    settings.width = 40;
    settings.height = 30;
    std::vector<Image> images;
    const Workers two(2);
    const Workers other(2);
    for (const Execution& execution : {Execution{}, two.execution(), other.execution()}) {
      const auto task = make_render_task(prepared, prepared->scene.cameras[0], photons, settings, execution);
      ASSERT_TRUE(task.ok());
      const MapSource maps = [&](const MapKey& key, const Execution& e) { return build_photon_maps(*prepared, key, e); };
      auto image = render_pass(*task, 3, maps, execution);
      ASSERT_TRUE(image.ok());
      images.push_back(std::move(image->radiance));
    }
    EXPECT_EQ(images[0].pixels, images[1].pixels) << method_name(method);
    EXPECT_EQ(images[0].pixels, images[2].pixels) << method_name(method);
  }
}

// The plan tells the radius that was asked for, and 0 where each gather chooses its own.
TEST(RenderTask, PlanTellsTheRadiusAskedFor) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::box({-1, -1, -1}, {1, 1, 6}, true), test::add_material(scene, test::lambert(Rgb(0.5f))));
  test::add_point_light(scene, {0, 0, 0}, Rgb(1));
  const auto prepared = test::prepared(std::move(scene));
  for (const float radius : {0.0f, 0.25f}) {
    RenderSettings settings;
    settings.method = Method::progressive;
    settings.radius = radius;
    const auto task = make_render_task(prepared, prepared->scene.cameras[0], {1000, 0}, settings, Execution{});
    ASSERT_TRUE(task.ok());
    EXPECT_EQ(task->plan.radius, radius);
  }
}

TEST(RenderTask, PlanTellsHowManyPhotonsARadiusHolds) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::box({0, 0, 0}, {1, 1, 1}, true), test::add_material(scene, test::lambert(Rgb(0.5f))));
  test::add_point_light(scene, {0.5f, 0.5f, 0.5f}, Rgb(1));
  const auto prepared = test::prepared(std::move(scene));
  RenderSettings settings;
  settings.method = Method::progressive;
  settings.radius = 0.05f;
  const PhotonSettings photons{100'000, 0};
  const auto task = make_render_task(prepared, prepared->scene.cameras[0], photons, settings, Execution{});
  ASSERT_TRUE(task.ok());
  const auto item = std::ranges::find(task->plan.items, "radius", &PlanItem::feature);
  ASSERT_NE(item, task->plan.items.end());
  const double told = std::stod(item->reason.substr(item->reason.find("holds ") + 6));
  const auto maps = build_photon_maps(*prepared, {prepared->digest, photons, 0}, Execution{});
  const PhotonMap& map = (*maps)->global;
  ASSERT_GT(map.size(), 1000u);
  std::vector<std::uint32_t> counts;
  for (std::uint32_t i = 0; i < map.size(); i += 100) {
    std::uint32_t others = 0;
    for (std::uint32_t k = 0; k < map.size(); ++k) {
      others += k != i && glm::distance(map.position(i), map.position(k)) < settings.radius;
    }
    counts.push_back(others);
  }
  std::ranges::nth_element(counts, counts.begin() + counts.size() / 2);
  // The pilot tells a density by 15 photons, whose number scatters by a quarter, and so skews the median by some per cent;
  // two digits are told.
  EXPECT_NEAR(told / counts[counts.size() / 2], 1, 0.2) << item->reason;
}

// Pictures by such radii lack all light of photons, and their error estimate does not know.
TEST(RenderTask, ARadiusSuitsTheSizeOfTheScene) {
  for (const float scale : {1e-3f, 1.0f, 1e4f}) {
    Scene scene = test::empty_scene();
    test::add_mesh(scene, test::box(Vec3(-scale), Vec3(scale), true), test::add_material(scene, test::lambert(Rgb(0.5f))));
    test::add_point_light(scene, {0, 0, 0}, Rgb(1));
    const auto prepared = test::prepared(std::move(scene));
    const auto task = [&](float radius) {
      RenderSettings settings;
      settings.radius = radius * scale;
      return make_render_task(prepared, prepared->scene.cameras[0], {1000, 0}, settings, Execution{});
    };
    for (const float fine : {1e-5f, 0.1f, 3.0f}) EXPECT_TRUE(task(fine).ok()) << fine << " of " << scale;
    for (const float wrong : {1e-40f, 1e-7f, 4.0f, 1e30f}) {
      const auto refused = task(wrong);
      ASSERT_FALSE(refused.ok()) << wrong << " of " << scale;
      EXPECT_EQ(refused.error().where, "/radius");
    }
  }
}

}  // namespace
}  // namespace photond
