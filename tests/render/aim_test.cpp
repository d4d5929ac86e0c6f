// Small casters in wide places: what aiming at them is worth, and that it changes nothing but the noise.
#include <gtest/gtest.h>

#include <functional>

#include "tests/render/look.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

using namespace test;

Scene small_lens() {
  Scene scene = empty_scene();
  add_mesh(scene, parallelogram({-10, 0, -10}, {0, 0, 20}, {20, 0, 0}), add_material(scene, lambert(Rgb(0.5f))));
  add_mesh(scene, sphere({0, 0.25f, 0}, 0.1f), add_material(scene, glass(1.5f)));
  return scene;
}

Scene under(LightType type) {
  Scene scene = small_lens();
  PunctualLight light;
  light.type = type;
  light.position = {0, 6, 0};
  light.direction = {0, -1, 0};
  light.intensity = Rgb(type == LightType::directional ? 3 : 100);
  scene.lights.push_back(light);
  return scene;
}

Scene under_a_sheet() {
  Scene scene = small_lens();
  add_mesh(scene, parallelogram({-2, 6, -2}, {4, 0, 0}, {0, 0, 4}), add_material(scene, emitter(Rgb(5))));
  return scene;
}

Scene under_a_sky() {
  Scene scene = small_lens();
  std::vector<Rgb> pixels(64 * 32, Rgb(0.3f));
  for (std::size_t x = 0; x < 64; ++x) pixels[x] = Rgb(100);   // about the zenith
  set_environment(scene, {.radiance = Rgb(1), .map = std::make_shared<EnvironmentMap>(64, 32, pixels)});
  return scene;
}

// The same without aims.
std::shared_ptr<const PreparedScene> unaimed(Scene scene) {
  auto plain = std::const_pointer_cast<PreparedScene>(prepared(std::move(scene)));
  plain->lights = Lights(plain->scene, plain->bounds);
  plain->aim = {};
  return plain;
}

// Irradiance by caustic photons within .05 m below the ball, in W/m², pass by pass.
Sample caustic(const PreparedScene& scene, int passes) {
  Sample flux;
  for (int pass = 0; pass < passes; ++pass) {
    const auto maps = shoot_maps(scene, 20'000, 5, static_cast<std::uint32_t>(pass));
    double sum = 0;
    for (std::uint32_t leaf = 0; leaf < maps->caustic.leaf_count(); ++leaf) {
      const PhotonLeaf& photons = maps->caustic.leaf(leaf);
      for (std::uint32_t i = 0; i < PhotonLeaf::kSize; ++i) {
        const bool inside = photons.x[i] * photons.x[i] + photons.z[i] * photons.z[i] < 0.05f * 0.05f;
        if (inside && std::abs(photons.y[i]) < 1e-3f) sum += static_cast<double>(decode_flux(photons.flux[0][i]));
      }
    }
    flux.add(sum / (maps->emitted * std::numbers::pi * 0.05 * 0.05));
  }
  return flux;
}

struct Gain {
  std::string name;
  Scene scene;
  double factor;    // by which the variance must fall at least
};

TEST(AimedCausticStatistical, HasTheSameLightWithMuchLessNoise) {
  // Measured: 1000, 1200, 660 and 1900, of which a tenth is asked for.
  const Gain gains[] = {{"sun", under(LightType::directional), 100},
                        {"lamp", under(LightType::point), 120},
                        {"sheet", under_a_sheet(), 66},
                        {"sky", under_a_sky(), 190}};
  for (const Gain& gain : gains) {
    const auto aimed = prepared(gain.scene);
    ASSERT_TRUE(aimed->aim.active) << gain.name;
    const Sample with = caustic(*aimed, 24), without = caustic(*unaimed(gain.scene), 240);
    EXPECT_NEAR(with.mean, without.mean, kSigmas * std::hypot(with.standard_error(), without.standard_error())) << gain.name;
    const double variance_with = with.m2 / static_cast<double>(with.count - 1);
    const double variance_without = without.m2 / static_cast<double>(without.count - 1);
    EXPECT_GT(variance_without, gain.factor * variance_with) << gain.name;
    RecordProperty(gain.name, std::to_string(variance_without / variance_with));
  }
}

// The photons' light and the paths' share of it, in the method that shares.
TEST(AimedCausticStatistical, LooksAlikeByEveryMethod) {
  for (const auto& [name, scene] : {std::pair("sheet", under_a_sheet()), std::pair("sky", under_a_sky())}) {
    const auto aimed = prepared(scene);
    const Look look{.from = {0.4f, 0.3f, 0}, .at = {0, 0, 0}, .radius = 0.02f, .photons = 20'000, .passes = 60, .side = 16};
    const auto reference = see(unaimed(scene), Method::path, 1, {look.from, look.at, look.radius, 1, 400, 64});
    for (const Method method : {Method::hybrid, Method::progressive}) {
      const auto seen = see(aimed, method, 2, look);
      // The kernel of .02 m on a spot that bends over .05 m: (.4)²/6.
      EXPECT_NEAR(seen[0].mean, reference[0].mean,
                  kSigmas * std::hypot(seen[0].standard_error(), reference[0].standard_error()) + 0.027 * reference[0].mean)
          << name << ", " << method_name(method);
    }
  }
}

}  // namespace
}  // namespace photond
