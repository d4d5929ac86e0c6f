#include "core/trace/aim.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "core/math/frame.h"
#include "core/trace/casters.h"
#include "core/trace/prepare.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

using test::Sample;

// Two balls that overlap and one around the point itself.
Aim three_balls(float share = 0.5f) {
  const Ball balls[] = {{{0, 0, 3}, 1.2f}, {{1, 0.5f, 2.5f}, 1}, {{0.1f, -0.3f, 0.2f}, 2}};
  const double weights[] = {3, 1, 0.5};
  return {balls, weights, share};
}

TEST(Aim, DirectionsMatchTheirPdf) {
  const Aim aim = three_balls();
  EXPECT_GT(test::chi2_sphere(
                [&](Rng& rng) {
                  const std::uint32_t ball = aim.choose(rng.next());
                  return aim.direction(Vec3(0), ball, rng.next2());
                },
                [&](const Vec3& w) { return static_cast<double>(aim.pdf_w(Vec3(0), w)); }, 60),
            test::kSignificance);
}

TEST(Aim, PlacesMatchTheirPdf) {
  const Aim aim = three_balls();
  const Vec3 direction = glm::normalize(Vec3(1, 2, -0.5f));
  const Frame frame(direction);
  constexpr int kSide = 40, kFine = 20, kDraws = 200'000;
  constexpr float kReach = 6;   // metres from the middle
  std::vector<double> observed(kSide * kSide), expected(kSide * kSide);
  Rng rng(1, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < kDraws; ++i) {
    const std::uint32_t ball = aim.choose(rng.next());
    const Vec3 local = frame.to_local(aim.place(direction, ball, rng.next2()));
    const int x = static_cast<int>((local.x / kReach + 1) / 2 * kSide), y = static_cast<int>((local.y / kReach + 1) / 2 * kSide);
    ASSERT_TRUE(x >= 0 && x < kSide && y >= 0 && y < kSide);
    ++observed[static_cast<std::size_t>(y * kSide + x)];
  }
  constexpr int kGrid = kSide * kFine;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const auto at = [&](int k) { return ((static_cast<float>(k) + 0.5f) / kGrid * 2 - 1) * kReach; };
    const Vec3 point = frame.to_world({at(i % kGrid), at(i / kGrid), 0.7f});
    const double cell = 4.0 * kReach * kReach / (kGrid * kGrid);
    expected[static_cast<std::size_t>(i / kGrid / kFine * kSide + i % kGrid / kFine)] +=
        static_cast<double>(aim.pdf_a(point, direction)) * cell * kDraws;
  }
  EXPECT_GT(test::chi2_test(observed, expected), test::kSignificance);
}

// A ball of a millimetre at a kilometre: sampled and judged alike but for rounding at its rim.
TEST(Aim, SmallFarBallsKeepTheirDensity) {
  const Ball ball{{600, -800, 3}, 1e-3f};
  const double one[] = {1};
  const Aim aim({&ball, 1}, one, 1);
  Rng rng(1, RngPurpose::pilot, 0, 0);
  int lost = 0;
  const double expected = std::pow(1000.0045 / 1e-3, 2) / std::numbers::pi;
  for (int i = 0; i < 10'000; ++i) {
    const Vec3 w = aim.direction(Vec3(0), 0, rng.next2());
    EXPECT_NEAR(static_cast<double>(aim.pdf_w(Vec3(0), w, 0)), expected, 1e-5 * expected);
    lost += aim.pdf_w(Vec3(0), w) == 0;
  }
  // A direction is rounded by 6·10⁻⁸, which at a kilometre is 6 % of the ball's radius.
  EXPECT_LT(lost, 1500);
}

// A metal of factors 1 whose texture has texels of some roughness and metalness.
template <class Texel>
Scene textured_metal(const std::vector<std::pair<int, int>>& texels) {
  Scene scene;
  TextureImage image{.width = static_cast<int>(texels.size()), .height = 1};
  for (const auto& [roughness, metal] : texels) {
    for (const int value : {0, roughness, metal, 255}) {
      if constexpr (sizeof(Texel) == 1) image.u8.push_back(static_cast<Texel>(value));
      if constexpr (sizeof(Texel) == 2) image.u16.push_back(static_cast<Texel>(257 * value));
    }
  }
  scene.images.push_back(image);
  scene.textures.push_back({});
  Material material = test::mirror(Rgb(1));
  material.roughness = 1;
  material.metallic_roughness_texture.texture = 0;
  scene.materials.push_back(material);
  return scene;
}

template <class Texel>
void expect_casting(const std::vector<std::pair<int, int>>& texels, bool casts, bool bundles, bool mirrors) {
  const Scene scene = textured_metal<Texel>(texels);
  EXPECT_EQ(casts_caustics(scene, scene.materials[0]), casts);
  EXPECT_EQ(bundles_light(scene, scene.materials[0]), bundles);
  EXPECT_EQ(mirrors_points(scene, scene.materials[0]), mirrors);
}

TEST(Casters, AreToldByTheTexelsOfMetal) {
  expect_casting<std::uint8_t>({{255, 255}, {200, 255}, {255, 0}}, false, false, false);
  expect_casting<std::uint8_t>({{255, 255}, {200, 255}, {0, 255}}, true, true, true);
  expect_casting<std::uint16_t>({{255, 255}, {0, 255}}, true, true, true);
  expect_casting<std::uint16_t>({{255, 255}, {100, 255}}, true, true, false);
  expect_casting<std::uint8_t>({{255, 255}, {120, 200}}, true, true, false);   // roughness .47, α .22
  expect_casting<std::uint8_t>({{255, 255}, {0, 100}}, false, false, true);    // smooth where it is no metal
}

TEST(Casters, GroupsWhatLiesTogether) {
  Scene scene = test::empty_scene();
  const std::uint32_t clear = test::add_material(scene, test::glass(1.5f));
  test::add_mesh(scene, test::sphere({-5, 0, 0}, 1), clear);
  test::add_mesh(scene, test::sphere({5, 0, 0}, 0.5f), test::add_material(scene, test::mirror(Rgb(1))));
  test::add_mesh(scene, test::box({-50, -50, -50}, {50, 50, 50}), test::add_material(scene, test::lambert(Rgb(1))));
  const auto balls = caster_balls(test::prepared(std::move(scene))->scene, 16);
  ASSERT_EQ(balls.size(), 2u);
  const Ball& large = balls[balls[0].radius > balls[1].radius ? 0 : 1];
  const Ball& small = balls[balls[0].radius > balls[1].radius ? 1 : 0];
  EXPECT_LT(glm::distance(large.center, Vec3(-5, 0, 0)), 0.01f);
  EXPECT_NEAR(large.radius, 1, 0.01);
  EXPECT_LT(glm::distance(small.center, Vec3(5, 0, 0)), 0.01f);
  EXPECT_NEAR(small.radius, 0.5, 0.01);
}

TEST(Casters, HaveAnUpperNumber) {
  Scene scene = test::empty_scene();
  const std::uint32_t clear = test::add_material(scene, test::glass(1.5f));
  for (int i = 0; i < 40; ++i) test::add_mesh(scene, test::sphere({3 * i, i % 7, 0}, 0.2f, 4), clear);
  const auto prepared = test::prepared(std::move(scene));
  const auto balls = caster_balls(prepared->scene, 16);
  EXPECT_EQ(balls.size(), 16u);
  for (int i = 0; i < 40; ++i) {
    const Vec3 center(3 * i, i % 7, 0);
    EXPECT_TRUE(std::any_of(balls.begin(), balls.end(), [&](const Ball& ball) {
      return glm::distance(ball.center, center) < ball.radius;
    })) << i;
  }
}

// A small ball of glass in a wide place.
Scene small_glass() {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::parallelogram({-10, 0, -10}, {0, 0, 20}, {20, 0, 0}),
                 test::add_material(scene, test::lambert(Rgb(0.5f))));
  test::add_mesh(scene, test::sphere({1, 0.3f, 2}, 0.1f, 16), test::add_material(scene, test::glass(1.5f)));
  return scene;
}

PunctualLight lamp(LightType type) {
  PunctualLight light;
  light.type = type;
  light.position = {0, 4, 0};
  light.direction = glm::normalize(Vec3(0.3f, -1, 0.2f));
  light.intensity = {4, 2, 1};
  light.cos_outer = 0.5f;
  light.cos_inner = 0.8f;
  return light;
}

std::vector<std::pair<std::string, Scene>> lit_scenes() {
  std::vector<std::pair<std::string, Scene>> scenes;
  for (const LightType type : {LightType::point, LightType::spot, LightType::directional}) {
    scenes.emplace_back("light of type " + std::to_string(static_cast<int>(type)), small_glass());
    scenes.back().second.lights.push_back(lamp(type));
  }
  scenes.emplace_back("a far point", small_glass());
  test::add_point_light(scenes.back().second, {100, 300, 50}, Rgb(1e4f));
  for (const bool both : {false, true}) {
    scenes.emplace_back(both ? "a sheet" : "a lamp", small_glass());
    Material m = test::emitter({3, 2, 1});
    m.double_sided = both;
    test::add_mesh(scenes.back().second, test::parallelogram({-2, 5, -2}, {4, 0, 0}, {0, 0, 4}),
                   test::add_material(scenes.back().second, m));
  }
  scenes.emplace_back("a sky", small_glass());
  std::vector<Rgb> pixels(16 * 8, Rgb(0.2f));
  pixels[16 * 2 + 5] = Rgb(40);
  set_environment(scenes.back().second,
                  {.radiance = Rgb(1), .map = std::make_shared<EnvironmentMap>(16, 8, pixels), .rotation = 1});
  return scenes;
}

// A mirror over a dark floor below a lamp, in the open or in a bright room.
AimFinding aim_at_mirror(bool in_room) {
  Scene scene = test::empty_scene();
  const std::uint32_t dark = test::add_material(scene, test::lambert(Rgb(0.05f)));
  const std::uint32_t grey = test::add_material(scene, test::lambert(Rgb(0.7f)));
  test::add_mesh(scene, test::parallelogram({-2, 0, -2}, {0, 0, 4}, {4, 0, 0}), dark);
  test::add_mesh(scene, test::sphere({0, 0.9f, 0}, 0.8f), test::add_material(scene, test::mirror(Rgb(0.9f))));
  if (in_room) test::add_mesh(scene, test::box({-2, -1, -2}, {2, 4, 2}, true), grey);
  test::add_point_light(scene, {1, 3.5f, 0}, Rgb(1));
  return test::prepared(std::move(scene))->aim;
}

// Where photons light a room, too, what the mirror throws is worth little of their loss: a tenth at most.
TEST(LearnAim, AimsAsManyPathsAsWhatElseIsLitLeaves) {
  const AimFinding open = aim_at_mirror(false), room = aim_at_mirror(true);
  EXPECT_TRUE(open.active);
  EXPECT_GT(open.share, 0.2);
  EXPECT_LT(open.effort, 0.6);
  EXPECT_TRUE(room.reached);
  EXPECT_LE(room.share, 0.1);
  EXPECT_EQ(room.effort, 1);
}

// Flux per emitted path into parts of the scene: all of it, with what is not sent, that through the glass, through a ring around it, and
// through quarters of the place.
std::vector<Sample> fluxes(const PreparedScene& scene, const Lights& lights, std::uint64_t seed) {
  std::vector<Sample> flux(7);
  for (std::uint64_t i = 0; i < 200'000; ++i) {
    Rng rng(seed, RngPurpose::photon, 0, i);
    const std::uint32_t light = lights.choose(rng.next());
    const EmissionSample s = lights.sample_emission(scene.scene, light, rng);
    const double power = static_cast<double>(s.flux.x);
    const Vec3 to_glass = Vec3(1, 0.3f, 2) - s.ray.origin;
    const float beside = glm::dot(to_glass, s.ray.direction) > 0 ? glm::length(glm::cross(to_glass, s.ray.direction)) : 1;
    const float t = -s.ray.origin.y / s.ray.direction.y;
    const Vec3 floor = s.ray.origin + t * s.ray.direction;
    const bool on_floor = t > 0 && std::abs(floor.x) < 10 && std::abs(floor.z) < 10;
    flux[0].add(power * (1 + static_cast<double>(lights.unsent(light))));
    flux[1].add(beside < 0.1f ? power : 0);
    flux[2].add(beside >= 0.1f && beside < 0.3f ? power : 0);
    for (std::size_t q = 0; q < 4; ++q) {
      const std::size_t quarter = (floor.x < 1 ? 1u : 0u) + (floor.z < 2 ? 2u : 0u);
      flux[3 + q].add(on_floor && q == quarter ? power : 0);
    }
  }
  return flux;
}

TEST(AimedEmission, BringsTheSameFluxEverywhere) {
  for (auto& [name, scene] : lit_scenes()) {
    const auto aimed = test::prepared(std::move(scene));
    EXPECT_TRUE(aimed->aim.active) << name;
    const Lights ordinary(aimed->scene, aimed->bounds);
    const auto with = fluxes(*aimed, aimed->lights, 1), without = fluxes(*aimed, ordinary, 2);
    for (std::size_t i = 0; i < with.size(); ++i) {
      // Of all but the last significant digits of sums in floats, where all paths carry the same.
      const double rounding = 1e-6 * without[i].mean;
      EXPECT_NEAR(with[i].mean, without[i].mean,
                  test::kSigmas * std::hypot(with[i].standard_error(), without[i].standard_error()) + rounding)
          << name << ", part " << i;
    }
    EXPECT_LT(with[1].standard_error(), 0.35 * without[1].standard_error()) << name;
  }
}

// Both sides of a merge must speak of the same density.
TEST(AimedEmission, TellsTheEtendueThatPathsHave) {
  for (auto& [name, scene] : lit_scenes()) {
    const auto aimed = test::prepared(std::move(scene));
    Rng rng(3, RngPurpose::pilot, 0, 0);
    int differ = 0, seen = 0;
    for (int i = 0; i < 4000; ++i) {
      const EmissionSample s = aimed->lights.sample_emission(aimed->scene, rng);
      if (s.etendue == 0 || is_black(s.flux)) continue;
      float told = 0;
      if (aimed->scene.environment.active()) {
        const float pdf = aimed->lights.pdf_environment(aimed->scene, -s.ray.direction);
        told = aimed->lights.environment_etendue(pdf, s.ray.origin + 20.0f * s.ray.direction, -s.ray.direction);
      } else {
        const Ray back{s.ray.origin + 0.1f * s.ray.direction, -s.ray.direction};
        const Hit hit = aimed->accel.intersect(back);
        ASSERT_TRUE(hit.found());
        told = aimed->lights.etendue(aimed->scene, make_surface(aimed->scene, back, hit), s.ray.direction);
      }
      ++seen;
      differ += std::abs(told - s.etendue) > 1e-3f * s.etendue;
    }
    // Paths by the rim of a ball or of a texel's cell, a thousandth of those that aim.
    EXPECT_LE(differ, 20) << name;
    EXPECT_TRUE(!aimed->lights.extended() || seen > 1000) << name;
  }
}

// Of the same random numbers: the results differ by the contraction of products and sums only, but for paths by the rim
// of a ball, since densities are taken at the ray's origin, off the surface.
TEST(AimedEmission, LanesEmitWhatSingleSamplesDo) {
  for (auto& [name, scene] : lit_scenes()) {
    const auto aimed = test::prepared(std::move(scene));
    const Lights& lights = aimed->lights;
    const auto lanes = std::make_unique<EmissionLanes>();
    Rng rng(5, RngPurpose::pilot, 0, 0);
    int in_lanes = 0, differ = 0;
    constexpr int kPaths = 4000;
    for (int i = 0; i < kPaths; ++i) {
      const std::uint32_t light = lights.choose(rng.next());
      Rng same = rng;
      const EmissionSample single = lights.sample_emission(aimed->scene, light, same);
      const bool begun = lights.begin_emission(aimed->scene, light, rng, 0, *lanes);
      if (!begun) {
        rng = same;
        continue;
      }
      ++in_lanes;
      lanes->emit(1);
      lights.share_emission(aimed->scene, light, 0, *lanes);
      EXPECT_EQ(rng.next_uint(), same.next_uint()) << name;
      EXPECT_LT(glm::distance(lanes->direction[0], single.ray.direction), 1e-5f) << name;
      EXPECT_LT(glm::distance(lanes->position[0], single.ray.origin), 1e-5f) << name;
      differ += std::abs(lanes->etendue[0] - single.etendue) > 1e-4f * single.etendue ||
                glm::distance(lanes->flux[0], single.flux) > 1e-4f * max_component(single.flux);
    }
    const bool triangles = lights.probability(0) < 1;   // the others have one light
    EXPECT_LE(differ, 20) << name;
    EXPECT_EQ(in_lanes, triangles ? kPaths : 0) << name;
  }
}

// Chosen now and then, since dim lights have a floor: nothing leaves them.
TEST(AimedEmission, NothingLeavesTrianglesWithoutArea) {
  Scene scene = small_glass();
  Mesh lamp = test::parallelogram({-2, 5, -2}, {4, 0, 0}, {0, 0, 4});
  lamp.triangles.push_back({0, 1, 1});
  test::add_mesh(scene, lamp, test::add_material(scene, test::emitter({3, 2, 1})));
  const auto aimed = test::prepared(std::move(scene));
  ASSERT_TRUE(aimed->aim.active);
  Rng rng(6, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < 2000; ++i) {
    const EmissionSample s = aimed->lights.sample_emission(aimed->scene, 2, rng);
    ASSERT_EQ(s.flux, Rgb(0));
    ASSERT_EQ(s.etendue, 0);
  }
  const auto lanes = std::make_unique<EmissionLanes>();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(aimed->lights.begin_emission(aimed->scene, 2, rng, 0, *lanes));
    lanes->emit(1);
    aimed->lights.share_emission(aimed->scene, 2, 0, *lanes);
    ASSERT_EQ(lanes->flux[0], Rgb(0));
    ASSERT_EQ(lanes->etendue[0], 0);
  }
}

TEST(LearnAim, IsActiveOnlyWhereItPays) {
  Scene none = test::empty_scene();
  test::add_mesh(none, test::box({-1, -1, -1}, {1, 1, 1}), test::add_material(none, test::lambert(Rgb(1))));
  none.lights.push_back(lamp(LightType::directional));
  Scene hidden = small_glass();
  test::add_mesh(hidden, test::box({0.7f, 0.1f, 1.7f}, {1.3f, 0.7f, 2.3f}), 0);
  hidden.lights.push_back(lamp(LightType::directional));
  const auto finding = [](Scene scene) { return test::prepared(std::move(scene))->aim; };
  EXPECT_FALSE(finding(none).casters);
  EXPECT_FALSE(finding(hidden).reached);
  EXPECT_TRUE(finding(hidden).casters);
  Scene filled = test::empty_scene();
  test::add_mesh(filled, test::parallelogram({-1, 0, -1}, {0, 0, 2}, {2, 0, 0}),
                 test::add_material(filled, test::lambert(Rgb(1))));
  test::add_mesh(filled, test::parallelogram({-1, 1, -1}, {0, 0, 2}, {2, 0, 0}),
                 test::add_material(filled, test::glass(1.33f)));
  filled.lights.push_back(lamp(LightType::directional));
  const AimFinding water = finding(filled);
  EXPECT_TRUE(water.reached);
  EXPECT_FALSE(water.active);
  EXPECT_GT(water.ordinary, 0.1);
}

// The same bits whoever computes them.
TEST(LearnAim, DoesNotDependOnThreads) {
  auto scenes = lit_scenes();
  for (auto& [name, scene] : scenes) {
    const auto one = prepare(scene, Execution{});
    const auto many = prepare(scene, test::workers().execution());
    ASSERT_TRUE(one.ok() && many.ok());
    Rng a(1, RngPurpose::pilot, 0, 0), b = a;
    for (int i = 0; i < 500; ++i) {
      const EmissionSample s = (*one)->lights.sample_emission((*one)->scene, a);
      const EmissionSample t = (*many)->lights.sample_emission((*many)->scene, b);
      ASSERT_EQ(s.ray.direction, t.ray.direction) << name;
      ASSERT_EQ(s.flux, t.flux) << name;
    }
  }
}

}  // namespace
}  // namespace photond
