#include "core/trace/lights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "core/math/warp.h"
#include "core/trace/prepare.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

// A patch, a double-sided patch and the environment around a bare point.
std::shared_ptr<const PreparedScene> lit_point() {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::parallelogram({-1, -1, 2}, {0, 2, 0}, {2, 0, 0}),
                 test::add_material(scene, test::emitter(Rgb(2))));
  Material both = test::emitter(Rgb(1));
  both.double_sided = true;
  test::add_mesh(scene, test::parallelogram({-3, -1, -1}, {0, 2, 0}, {0, 0, 2}), test::add_material(scene, both));
  scene.environment.radiance = Rgb(0.1f);
  return test::prepared(std::move(scene));
}

TEST(Lights, DirectDirectionsMatchTheirPdf) {
  const auto scene = lit_point();
  const Vec3 point{0.3f, -0.2f, 0.1f};
  const auto pdf = [&](const Vec3& wi) {
    const Hit hit = scene->accel.intersect({point, wi});
    const float environment = scene->lights.pdf_environment(scene->scene, wi);
    if (!hit.found()) return static_cast<double>(environment);
    const SurfacePoint s = make_surface(scene->scene, {point, wi}, hit);
    return static_cast<double>(environment + scene->lights.pdf_direct(scene->scene, s, wi, hit.t));
  };
  const double p = test::chi2_sphere(
      [&](Rng& rng) {
        const Vec2 u = rng.next2();
        return scene->lights.sample_direct(scene->scene, point, {u, rng.next()}).wi;
      },
      pdf, 80);
  EXPECT_GT(p, test::kSignificance);
}

// ∫ L over the sphere by samples equals the same by the geometry.
TEST(Lights, DirectEstimateIsUnbiased) {
  const auto scene = lit_point();
  const Vec3 point{0.3f, -0.2f, 0.1f};
  const test::Sample sampled = test::draw(400'000, [&](Rng& rng) {
    const Vec2 u = rng.next2();
    const DirectSample s = scene->lights.sample_direct(scene->scene, point, {u, rng.next()});
    const bool hidden = s.infinite && scene->accel.occluded(Ray{point, s.wi});
    return hidden ? 0.0 : static_cast<double>(s.radiance.x);
  });
  const test::Sample uniform = test::draw(400'000, [&](Rng& rng) {
    const Vec3 wi = square_to_sphere(rng.next2());
    const Hit hit = scene->accel.intersect({point, wi});
    if (!hit.found()) return 0.1 / kSpherePdf;
    return static_cast<double>(emitted_radiance(scene->scene, make_surface(scene->scene, {point, wi}, hit)).x) / kSpherePdf;
  });
  EXPECT_NEAR(sampled.mean, uniform.mean, 4.1 * std::hypot(sampled.standard_error(), uniform.standard_error()));
}

TEST(Lights, EmissionIsCosineDistributed) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                 test::add_material(scene, test::emitter(Rgb(1))));
  const auto prepared = test::prepared(std::move(scene));
  const Lights lights(prepared->scene, prepared->bounds);   // that may shine on nothing
  EXPECT_GT(test::chi2_sphere([&](Rng& rng) { return lights.sample_emission(prepared->scene, rng).ray.direction; },
                              [](const Vec3& w) { return std::max(w.z, 0.0f) * kInvPi; }),
            test::kSignificance);
}

// Of the same random numbers: the results differ by the contraction of products and sums only.
TEST(Lights, LanesEmitWhatSingleSamplesDo) {
  Scene scene = test::empty_scene();
  Material lamp = test::emitter({3, 2, 1});
  lamp.double_sided = true;
  test::add_mesh(scene, test::box({-1, -1, -1}, {1, 1, 1}), test::add_material(scene, lamp));
  const auto prepared = test::prepared(std::move(scene));
  const Lights& lights = prepared->lights;
  const auto lanes = std::make_unique<EmissionLanes>();
  std::vector<EmissionSample> single(kLanes);
  Rng rng(4, RngPurpose::pilot, 0, 0);
  for (int round = 0; round < 100; ++round) {
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      const std::uint32_t light = lights.choose(rng.next());
      Rng same = rng;
      single[k] = lights.sample_emission(prepared->scene, light, same);
      ASSERT_TRUE(lights.begin_emission(prepared->scene, light, rng, k, *lanes));
      EXPECT_EQ(lanes->flux[k], single[k].flux);
      EXPECT_EQ(lanes->etendue[k], single[k].etendue);
    }
    lanes->emit(kLanes);
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      constexpr float kUlps = 32 * 0x1p-23f;  // half a dozen roundings of numbers up to 1, with room
      EXPECT_LT(glm::distance(lanes->position[k], single[k].ray.origin), kUlps);
      EXPECT_LT(glm::distance(lanes->direction[k], single[k].ray.direction), kUlps);
    }
  }
}

TEST(Lights, SpotEmitsOnlyIntoItsCone) {
  Scene scene = test::empty_scene();
  PunctualLight spot;
  spot.type = LightType::spot;
  spot.direction = {0, 0, 1};
  spot.cos_outer = std::cos(kPi / 4);
  spot.cos_inner = 0.9f;
  scene.lights.push_back(spot);
  const auto prepared = test::prepared(std::move(scene));
  const test::Sample flux = test::draw(200'000, [&](Rng& rng) {
    const EmissionSample s = prepared->lights.sample_emission(prepared->scene, rng);
    EXPECT_GE(s.ray.direction.z, spot.cos_outer - 1e-6f);
    return static_cast<double>(s.flux.x);
  });
  // 2π I [(1 − cᵢ) + (cᵢ − cₒ)/3].
  EXPECT_TRUE(test::agrees(flux, 2 * kPi * ((1 - 0.9) + (0.9 - spot.cos_outer) / 3)));
}

// Paths of a scene's only light.
struct Leaving {
  test::Sample flux;   // of those that meet anything
  double met = 0;      // their share
  double sent = 0;     // power, with what is told as unsent
};

Leaving leaving(const PreparedScene& scene, int paths) {
  Leaving result;
  result.flux = test::draw(paths, [&](Rng& rng) {
    const EmissionSample s = scene.lights.sample_emission(scene.scene, rng);
    result.sent += static_cast<double>(s.flux.x) * (1 + static_cast<double>(scene.lights.unsent(0))) / paths;
    const bool found = scene.accel.intersect(s.ray).found();
    result.met += found ? 1.0 / paths : 0;
    return found ? static_cast<double>(s.flux.x) : 0;
  });
  return result;
}

// A square below one corner of which a point hangs, at heights inside and outside of the bounding sphere.
TEST(Lights, PathsOfFarPointsLeaveTowardsTheScene) {
  for (const float height : {0.5f, 3.0f, 100.0f, 1e6f}) {
    Scene scene = test::empty_scene();
    test::add_mesh(scene, test::parallelogram({0, 0, 0}, {0, 0, 2}, {2, 0, 0}), test::add_material(scene, test::lambert(Rgb(1))));
    test::add_point_light(scene, {0, height, 0}, Rgb(5));
    const auto prepared = test::prepared(std::move(scene));
    const auto [flux, met, sent] = leaving(*prepared, 200'000);
    // Solid angle of a rectangle from above its corner: atan(ab / (h √(a² + b² + h²))).
    const double h = static_cast<double>(height);
    EXPECT_TRUE(test::agrees(flux, 5 * std::atan(4 / (h * std::sqrt(8 + h * h))))) << height;
    EXPECT_NEAR(sent, 20 * kPi, 1e-4 * 20 * kPi) << height;
    EXPECT_NEAR(prepared->lights.total_power(), 20 * kPi, 1e-5 * 20 * kPi) << height;
    // From far away its square of 4 m² fills as much of the sphere's disc of 2π m² as there is across.
    EXPECT_TRUE(height < 100 || std::abs(met - 2 / kPi) < 0.01) << height << ": " << met;
  }
}

// A spot that shines past the same square on all sides, partly on it, or from within the bounding sphere.
TEST(Lights, PathsOfFarSpotsLeaveTowardsTheScene) {
  for (const Vec3& from : {Vec3(1, 0.5f, 1), Vec3(1, 30, 1), Vec3(20, 30, 1)}) {
    Scene scene = test::empty_scene();
    test::add_mesh(scene, test::parallelogram({0, 0, 0}, {0, 0, 2}, {2, 0, 0}), test::add_material(scene, test::lambert(Rgb(1))));
    const PunctualLight spot = test::spot_light(from, Vec3(4, 0, 1) - from, 0.99f, 0.8f, 5);
    scene.lights.push_back(spot);
    const auto prepared = test::prepared(std::move(scene));
    const auto [flux, met, sent] = leaving(*prepared, 100'000);
    const test::Sample expected = test::draw(100'000, [&](Rng& rng) {
      const Vec3 to = Vec3(2 * rng.next(), 0, 2 * rng.next()) - from;
      const float distance_sq = glm::dot(to, to), distance = std::sqrt(distance_sq);
      return 4.0 * static_cast<double>(5 * spot.attenuation(to / distance) * -to.y / (distance_sq * distance));
    });
    EXPECT_NEAR(flux.mean, expected.mean, 4.1 * std::hypot(flux.standard_error(), expected.standard_error())) << from.x;
    const double power = 10 * kPi * ((1 - spot.cos_inner) + (spot.cos_inner - spot.cos_outer) / 3);
    // All over the cone, of which a twentieth shines fully, attenuation has a relative deviation of .89.
    EXPECT_NEAR(sent / power, 1, 4.1 * 0.89 / std::sqrt(1e5)) << from.x;
    EXPECT_TRUE(from.y < 1 || met > 0.3) << from.x << ": " << met;
  }
}

// What arrives decides: of two points that light a place alike, neither is chosen more often for being far and strong.
TEST(Lights, FarPointsAreChosenByWhatArrives) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::parallelogram({-1, 0, -1}, {0, 0, 2}, {2, 0, 0}), test::add_material(scene, test::lambert(Rgb(1))));
  test::add_point_light(scene, {0, 20, 0}, Rgb(1));
  test::add_point_light(scene, {0, 2000, 0}, Rgb(1e4f));
  const auto prepared = test::prepared(std::move(scene));
  EXPECT_NEAR(prepared->lights.probability(0), 0.5, 0.005);
}

// By all numbers there are: beside a sky that photons leave out, lamps that are chosen once in millions of times.
TEST(Lights, ThatCastAreChosenAsOftenAsTheyCount) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::sphere({0, 0, 0}, 1, 8), test::add_material(scene, test::glass(1.5f)));
  for (const float y : {2.0f, 3.0f}) {
    test::add_mesh(scene, test::parallelogram({-0.5f, y, 0.5f}, {1, 0, 0}, {0, 0, -1}),
                   test::add_material(scene, test::emitter(Rgb(y))));
  }
  test::add_point_light(scene, {0, 2, 2}, Rgb(1e-3f));
  scene.environment.radiance = Rgb(0.1f);
  const auto prepared = test::prepared(std::move(scene));
  const Lights& lights = prepared->lights;
  constexpr std::uint32_t kAll = 1 << 24;
  std::vector<std::uint32_t> counts(lights.size());
  for (std::uint32_t i = 0; i < kAll; ++i) ++counts[lights.choose_casting(static_cast<float>(i) / kAll)];
  EXPECT_EQ(counts.back(), 0u) << "the sky";
  EXPECT_NEAR(lights.casting_share() + static_cast<double>(lights.probability(5)), 1, 1e-15);
  for (std::uint32_t i = 0; i + 1 < lights.size(); ++i) {
    const double chosen = lights.casting_share() * counts[i] / kAll;
    const auto expected = static_cast<double>(lights.probability(i));
    EXPECT_NEAR(chosen * static_cast<double>(lights.casting_weight(i)), expected, 1e-6 * expected) << i;
  }
  EXPECT_LT(lights.probability(2), 1e-4f) << "of what meets nothing";
}

TEST(Lights, DimLightsKeepAFloor) {
  Scene scene = test::empty_scene();
  test::add_point_light(scene, {0, 0, 0}, Rgb(1e6f));
  test::add_point_light(scene, {1, 0, 0}, Rgb(1));
  const auto prepared = test::prepared(std::move(scene));
  int dim = 0;
  Rng rng(1, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < 10'000; ++i) dim += prepared->lights.sample_emission(prepared->scene, rng).ray.origin.x == 1;
  EXPECT_GT(dim, 150);  // half of the floor's 5 %
}

// The whole flux of textured emitters, however the texture is laid out.
TEST(Lights, TexturedEmitterShinesItsMeanRadiance) {
  Scene scene = test::empty_scene();
  TextureImage image;
  image.width = 2;
  image.height = 1;
  image.u8 = {255, 255, 255, 255, 0, 0, 0, 255};
  scene.images.push_back(image);
  Texture texture;
  texture.nearest = true;
  scene.textures.push_back(texture);
  Material m = test::emitter(Rgb(3));
  m.emission_texture.texture = 0;
  test::add_mesh(scene, test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), test::add_material(scene, m));
  const auto prepared = test::prepared(std::move(scene));
  const Lights lights(prepared->scene, prepared->bounds);   // that may shine on nothing
  const test::Sample flux = test::draw(100'000, [&](Rng& rng) {
    return static_cast<double>(lights.sample_emission(prepared->scene, rng).flux.x);
  });
  EXPECT_TRUE(test::agrees(flux, kPi * 3 / 2));
}

// At either end of what a file may say.
TEST(Lights, TinyAndHugeEmittersHaveTheirPower) {
  for (const float side : {1e-12f, 1e12f}) {
    Scene scene = test::empty_scene();
    test::add_mesh(scene, test::parallelogram({0, 0, 0}, {side, 0, 0}, {0, side, 0}),
                   test::add_material(scene, test::emitter(Rgb(1))));
    const double expected = kPi * static_cast<double>(side) * static_cast<double>(side);
    EXPECT_NEAR(test::prepared(std::move(scene))->lights.total_power() / expected, 1, 1e-5) << side;
  }
}

// Where a lamp is not, nothing shines: of what leaves it and of what is sampled of it from a point, a quarter.
TEST(Lights, ThinEmittersShineByTheirAlpha) {
  Scene scene = test::empty_scene();
  Material m = test::emitter(Rgb(3));
  m.alpha_mode = AlphaMode::blend;
  m.alpha = 0.25f;
  test::add_mesh(scene, test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), test::add_material(scene, m));
  const auto prepared = test::prepared(scene);
  const Lights lights(prepared->scene, prepared->bounds);   // that may shine on nothing
  EXPECT_NEAR(lights.total_power(), 3 * kPi / 4, 1e-5);
  Rng rng(3, RngPurpose::pilot, 0, 0);
  EXPECT_NEAR(lights.sample_emission(prepared->scene, rng).flux.x, 3 * kPi / 4, 1e-5);
  scene.materials[0].alpha_mode = AlphaMode::opaque;
  const auto opaque = test::prepared(scene);
  const Vec3 from(0.2f, 0.3f, 2), u(0.4f, 0.7f, 0.1f);
  EXPECT_NEAR(prepared->lights.sample_direct(prepared->scene, from, u).radiance.x,
              opaque->lights.sample_direct(opaque->scene, from, u).radiance.x / 4, 1e-6);
  scene.materials[0].alpha_mode = AlphaMode::mask;
  EXPECT_EQ(test::prepared(scene)->lights.total_power(), 0);
}

// A lamp is put where the ceiling is. Tilted, it lies there but for rounding.
TEST(Lights, PointsInASurfaceShineOnItsEitherSide) {
  for (const float tilt : {0.0f, 0.3f}) {
    const Vec3 down(std::sin(tilt), -std::cos(tilt), 0), along(std::cos(tilt), std::sin(tilt), 0), side(0, 0, 1);
    const Vec3 lamp = -2.5f * down + 0.3f * along - 0.4f * side;
    Scene scene = test::empty_scene();
    const auto white = test::add_material(scene, test::lambert(Rgb(0.5f)));
    for (int i = -4; i < 4; ++i) {
      for (int k = -4; k < 4; ++k) {
        const Vec3 corner = 0.5f * static_cast<float>(i) * along + 0.5f * static_cast<float>(k) * side;
        test::add_mesh(scene, test::parallelogram(corner - 2.5f * down, 0.5f * along, 0.5f * side), white);
        test::add_mesh(scene, test::parallelogram(corner, 0.5f * side, 0.5f * along), white);
      }
    }
    test::add_point_light(scene, lamp, Rgb(1));
    const auto prepared = test::prepared(std::move(scene));
    Rng rng(5, RngPurpose::pilot, 0, 0);
    int hidden = 0, lost = 0, downwards = 0;
    constexpr int kCount = 4000;
    for (int i = 0; i < kCount; ++i) {
      const Vec3 floor = (4 * rng.next() - 2) * along + (4 * rng.next() - 2) * side - 1e-3f * down;
      const DirectSample direct = prepared->lights.sample_direct(prepared->scene, floor, Vec3(rng.next2(), rng.next()));
      EXPECT_GT(direct.radiance.x, 0);
      hidden += prepared->accel.occluded({floor, direct.target - floor, 1});
      const Ray ray = prepared->lights.sample_emission(prepared->scene, rng).ray;
      if (glm::dot(ray.direction, down) < 0.05f) continue;   // rounding hides some of what grazes the ceiling
      ++downwards;
      const Hit hit = prepared->accel.intersect(ray);
      lost += hit.found() && hit.t < 2;
    }
    EXPECT_EQ(hidden, 0) << tilt;
    EXPECT_EQ(lost, 0) << tilt;
    EXPECT_GT(downwards, kCount / 3);
  }
}

}  // namespace
}  // namespace photond
