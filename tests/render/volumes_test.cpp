// Light, surfaces and camera within a volume that absorbs.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/look.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

using namespace test;

// A floor below a lamp, all in a liquid that halves light in a metre and refracts none.
TEST(Volumes, AbsorbWhatStaysWithinThem) {
  Scene scene = empty_scene();
  Material liquid = glass(1);
  liquid.attenuation_color = Rgb(0.5f);
  liquid.attenuation_distance = 1;
  add_mesh(scene, box({-4, -1, -4}, {4, 4, 4}), add_material(scene, liquid));
  add_mesh(scene, parallelogram({-2, 0, -2}, {0, 0, 4}, {4, 0, 0}), add_material(scene, lambert(Rgb(0.5f))));
  add_point_light(scene, {0, 2, 0}, Rgb(10));
  const auto room = prepared(std::move(scene));
  const double irradiance = 10 / 4.0 * 0.25;
  for (const Vec3& from : {Vec3(0.5f, 1.5f, 0.5f), Vec3(1, 3, 1), Vec3(2, 6, 2)}) {
    // The last of them is outside: two thirds of its way are in the liquid.
    const double within = static_cast<double>(glm::length(from)) * (from.y > 4 ? 4.0 / 6 : 1.0);
    const double expected = 0.5 / static_cast<double>(kPi) * irradiance * std::exp2(-within);
    for (const Method method : kMethods) {
      const Sample seen = see(room, method, 1, {.from = from, .at = {0, 0, 0}, .radius = 0.1f})[0];
      // Across the kernel the irradiance falls by .4 %.
      EXPECT_NEAR(seen.mean, expected, 0.005 * expected + kSigmas * seen.standard_error()) << method_name(method) << from.y;
    }
  }
}

// Light that is sampled through the rough border of a volume has the rest of its way in what lies beyond. Paths end
// after one bounce: a point in the middle of a ball is seen at its border after one metre in it, one outside from within
// after the 1.9 m that the path from the camera has been in it. The volume halves light in a metre.
TEST(Volumes, AbsorbLightThatIsSampledThroughTheirBorder) {
  const auto seen = [](float distance, const Vec3& from, const Vec3& light) {
    Scene scene = empty_scene();
    Material frosted = glass(1.3f);
    frosted.roughness = 0.7f;
    frosted.attenuation_color = Rgb(0.5f);
    frosted.attenuation_distance = distance;
    add_mesh(scene, sphere({0, 0, 0}, 1), add_material(scene, frosted));
    add_point_light(scene, light, Rgb(10));
    const Look look{.from = from, .at = {0, 0, 0}, .passes = 2, .max_depth = 1};
    return see(prepared(std::move(scene)), Method::path, 1, look)[0].mean;
  };
  const Vec3 outside{0.3f, 3, 0.4f}, middle{0}, within{0.1f, 0.9f, 0.1f}, below{0.3f, -5, 0.2f};
  const double clear_in = seen(kInfinity, outside, middle), clear_out = seen(kInfinity, within, below);
  ASSERT_GT(clear_in, 0);
  ASSERT_GT(clear_out, 0);
  EXPECT_NEAR(seen(1, outside, middle) / clear_in, 0.5, 0.002);    // facets lie up to .5 % deeper
  EXPECT_NEAR(seen(1, within, below) / clear_out, std::exp2(-1.9), 0.02);
}

// Liquid in contact with glass, both with colours: a ray that jumps over one of both borders takes its colour along.
TEST(Volumes, ThatTouchAbsorbAsThoseThatOverlap) {
  const auto seen = [](float overlap, Method method) {
    Scene scene = empty_scene();
    const auto coloured = [&](float ior, const Rgb& color) {
      Material m = glass(ior);
      m.attenuation_color = color;
      m.attenuation_distance = 0.3f;
      return add_material(scene, m);
    };
    add_mesh(scene, box({-1, 0, -1}, {1, 0.2f, 1}), coloured(1.5f, {0.5f, 0.9f, 0.9f}));
    add_mesh(scene, box({-1, -0.3f, -1}, {1, overlap, 1}), coloured(1.33f, {0.9f, 0.6f, 0.9f}));
    add_mesh(scene, parallelogram({-2, -2, 2}, {4, 0, 0}, {0, 0, -4}), add_material(scene, emitter(Rgb(1))));
    const Look look{.from = {0.1f, 1.2f, 0.1f}, .at = {0, 0, 0}, .passes = 40, .side = 8};
    return see(prepared(std::move(scene)), method, 1, look);
  };
  for (const Method method : {Method::path, Method::hybrid}) {
    const auto touching = seen(0, method), overlapping = seen(1e-3f, method);
    for (std::size_t channel : {0u, 1u}) {
      const double error = std::hypot(touching[channel].standard_error(), overlapping[channel].standard_error());
      // A millimetre of glass and liquid absorb up to .4 %.
      EXPECT_NEAR(touching[channel].mean, overlapping[channel].mean, 0.005 * overlapping[channel].mean + kSigmas * error)
          << method_name(method) << channel;
      EXPECT_GT(touching[channel].mean, 0.2);
    }
  }
}

double reflectance(double a, double b) { return (a - b) / (a + b) * ((a - b) / (a + b)); }

// What two borders one behind the other reflect of light that goes to and fro between them.
double together(double first, double second) { return first + (1 - first) * (1 - first) * second / (1 - first * second); }

// What is seen of a sky of radiance 1 from straight above two volumes.
double reflected_by(const Mesh& first, float ior, const Mesh& second, float other) {
  Scene scene = empty_scene();
  add_mesh(scene, first, add_material(scene, glass(ior)));
  add_mesh(scene, second, add_material(scene, glass(other)));
  add_mesh(scene, parallelogram({-9, 5, -9}, {18, 0, 0}, {0, 0, 18}), add_material(scene, emitter(Rgb(1))));
  const Look look{.from = {0.1f, 2, 0.1f}, .at = {0.1f, 0, 0.1f}, .passes = 200, .side = 16};
  return see(prepared(std::move(scene)), Method::path, 1, look)[0].mean;
}

// Between glass and water light knows nothing of air.
TEST(Volumes, ReflectByBothIndicesWhereTheyTouchOrNest) {
  const Mesh glass_above = box({-1, 0, -1}, {1, 0.2f, 1});
  const double wet = reflectance(1.5, 1.33), in_water = together(wet, reflectance(1.33, 1));
  const double touching = reflected_by(glass_above, 1.5f, box({-1, -0.3f, -1}, {1, 0, 1}), 1.33f);
  EXPECT_NEAR(touching, together(0.04, in_water), 0.002);   // .0617; .1105 with a gap
  // A bubble of air in glass.
  const double bubble = together(0.04, together(0.04, together(0.04, 0.04)));
  const double found = reflected_by(box({-1, -1, -1}, {1, 1, 1}), 1.5f, box({-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}), 1);
  EXPECT_NEAR(found, bubble, 0.003);                        // .143; .077 without it
}

// A lamp above a pane that lies on water: the ground is lit as if it were nearer by what the indices say.
TEST(Volumes, PhotonsPassFromGlassToWater) {
  Scene scene = empty_scene();
  add_mesh(scene, box({-1, 0, -1}, {1, 0.2f, 1}), add_material(scene, glass(1.5f)));
  add_mesh(scene, box({-1, -0.3f, -1}, {1, 0, 1}), add_material(scene, glass(1.33f)));
  // Of an albedo that sends next to nothing back to be reflected.
  add_mesh(scene, parallelogram({-0.9f, -0.29f, 0.9f}, {1.8f, 0, 0}, {0, 0, -1.8f}), add_material(scene, lambert(Rgb(0.02f))));
  PunctualLight spot;
  spot.type = LightType::spot;
  spot.position = {0, 2, 0};
  spot.direction = {0, -1, 0};
  spot.cos_inner = 0.97f;
  spot.cos_outer = 0.96f;
  spot.intensity = Rgb(10);
  scene.lights.push_back(spot);
  const auto room = prepared(std::move(scene));
  const double distance = 1.8 + 0.2 / 1.5 + 0.29 / 1.33;
  const double passed = 1 - together(0.04, reflectance(1.5, 1.33));
  const double expected = 0.02 / static_cast<double>(kPi) * 10 * passed / (distance * distance);
  for (const Method method : photon_methods()) {
    const Look look{.from = {0.2f, -0.1f, 0.1f}, .at = {0, -0.29f, 0}, .radius = 0.1f, .photons = 20'000, .passes = 30};
    const Sample seen = see(room, method, 1, look)[0];
    EXPECT_NEAR(seen.mean, expected, 0.005 * expected + kSigmas * seen.standard_error()) << method_name(method);
    EXPECT_LT(seen.standard_error(), 0.03 * expected);
  }
}

// A lamp of two triangles, half of it in a liquid that refracts none: photons of either half start where they are.
TEST(Volumes, LampsMayReachOutOfThem) {
  Scene scene = empty_scene();
  Material liquid = glass(1);
  liquid.attenuation_color = Rgb(0.6f);
  liquid.attenuation_distance = 0.5f;
  add_mesh(scene, box({-3, -0.5f, -1}, {0, 1.2f, 1}), add_material(scene, liquid));
  add_mesh(scene, parallelogram({-2, 1, -0.1f}, {4, 0, 0}, {0, 0, 0.2f}), add_material(scene, emitter(Rgb(10))));
  add_mesh(scene, parallelogram({-4, 0, 3}, {8, 0, 0}, {0, 0, -6}), add_material(scene, lambert(Rgb(0.5f))));
  const auto room = prepared(std::move(scene));
  for (const float x : {-1.0f, 1.0f}) {
    const Look look{.from = {x, 0.8f, 0.6f}, .at = {x, 0, 0.3f}, .radius = 0.05f, .photons = 20'000, .passes = 60, .side = 12};
    const Sample paths = see(room, Method::path, 1, look)[0];
    EXPECT_GT(paths.mean, 0.01) << x;
    for (const Method method : {Method::progressive, Method::hybrid}) {
      const Sample photons = see(room, method, 1, look)[0];
      const double error = std::hypot(paths.standard_error(), photons.standard_error());
      EXPECT_LT(error, 0.03 * paths.mean);
      EXPECT_NEAR(photons.mean, paths.mean, 0.01 * paths.mean + kSigmas * error) << method_name(method) << x;
    }
  }
}

// Rays of an orthographic camera start beside one another: one in a liquid, the next not.
TEST(Volumes, OrthographicCamerasMayStandInSeveral) {
  Scene scene = empty_scene();
  Material liquid = glass(1);
  liquid.attenuation_color = Rgb(0.5f);
  liquid.attenuation_distance = 1;
  add_mesh(scene, box({0, -2, -2}, {2, 2, 2}), add_material(scene, liquid));
  for (const float x : {-1.0f, 1.0f}) {
    add_mesh(scene, parallelogram({x - 0.8f, -1, 0}, {1.6f, 0, 0}, {0, 2, 0}), add_material(scene, emitter(Rgb(1))));
  }
  Camera camera = photond::look_at({-0.1f, 0, 1}, {-0.1f, 0, 0}, {0, 1, 0}, 1);
  camera.orthographic = true;
  camera.ymag = 0.7f;
  const auto room = prepared(std::move(scene));
  for (const Method method : kMethods) {
    RenderSettings settings;
    settings.method = method;
    settings.width = settings.height = 8;
    const auto task = make_render_task(room, camera, {1000, 1}, settings, Execution{});
    ASSERT_TRUE(task.ok());
    const auto image = render_pass(*task, 0, [&](const MapKey& key, const Execution& e) {
      return build_photon_maps(*room, key, e);
    }, Execution{});
    ASSERT_TRUE(image.ok());
    EXPECT_NEAR(image->radiance.pixels[0].x, 1, 1e-5f) << method_name(method);
    EXPECT_NEAR(image->radiance.pixels[7].x, 0.5, 1e-3f) << method_name(method);
  }
}

}  // namespace
}  // namespace photond
