// Caustics that photons and paths share: whatever the shares, they sum to the light.
#include <gtest/gtest.h>

#include "tests/render/look.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

using namespace test;

// So dark that what the receiver sends back is below a thousandth.
constexpr float kDark = 1e-3f;

// A shared caustic with N photons and the radius r has ρ = G/(π² r_m² N), r_m = r/4 and G = π·side² on a Lambert
// surface: what the sizes below are chosen by.
Look look(std::uint32_t photons, int passes) {
  return {.from = {1, 0.5f, 1}, .at = {1.2f, 0, 0}, .radius = 0.04f, .photons = photons, .passes = passes, .side = 8};
}

// Both within the noise of each other, and that below 2.5 %: a share forgotten or counted twice is more.
void expect_equal(const Sample& seen, const Sample& expected, const std::string& what, double slack = 0) {
  const double error = std::hypot(seen.standard_error(), expected.standard_error());
  EXPECT_LT(error, 0.025 * expected.mean) << what;
  EXPECT_NEAR(seen.mean, expected.mean, kSigmas * error + slack * expected.mean) << what;
}

Sample seen_by(Method method, const std::shared_ptr<const PreparedScene>& scene, const Look& look) {
  return see(scene, method, 1, look)[0];
}

Mesh square(float x, const Vec3& towards, float side) {
  // So high that it hides none of its mirror image from the receiver.
  const Vec3 corner(x, -side / 2, 0.5f);
  return towards.x > 0 ? parallelogram(corner, {0, side, 0}, {0, 0, side}) : parallelogram(corner, {0, 0, side}, {0, side, 0});
}

// Light from a square of this side, or from a point.
void add_lamp(Scene& scene, float x, float towards, float side, float flux) {
  if (side == 0) {
    scene.lights.push_back(spot_light({x, 0, 0.5f}, {towards, 0, 0}, 0.9f, 0.8f, flux * kInvPi));
    return;
  }
  add_mesh(scene, square(x, {towards, 0, 0}, side), add_material(scene, emitter(Rgb(flux / (kPi * side * side)))));
}

// A floor that one of a watt lights by way of the mirror x = 2; or the same, unfolded.
std::shared_ptr<const PreparedScene> floor_before_a_mirror(float side, bool unfolded, float roughness = 0,
                                                           const Material& floor = lambert(Rgb(kDark))) {
  Scene scene = empty_scene();
  add_mesh(scene, parallelogram({-3, -3, 0}, {5, 0, 0}, {0, 6, 0}), add_material(scene, floor));
  if (unfolded) {
    add_lamp(scene, 2.5f, -1, side, 0.9f);
  } else {
    Material metal = mirror(Rgb(0.9f));
    metal.roughness = roughness;
    add_mesh(scene, parallelogram({2, -3, 0}, {0, 0, 3}, {0, 6, 0}), add_material(scene, metal));
    add_lamp(scene, 1.5f, 1, side, 1);
  }
  return prepared(std::move(scene));
}

// ρ from 5·10⁻¹⁰ to 3.
TEST(MergeStatistical, SharesSumToTheLightOfAnySize) {
  struct Size {
    float side;
    std::uint32_t photons;
    int passes;
  };
  for (const Size& size : {Size{1e-4f, 60'000, 200}, Size{0.3f, 60'000, 200}, Size{1.4f, 20'000, 400}, Size{1.4f, 2000, 1000}}) {
    const Look at = look(size.photons, size.passes);
    const Sample expected = seen_by(Method::path, floor_before_a_mirror(size.side, true), at);
    const Sample seen = seen_by(Method::hybrid, floor_before_a_mirror(size.side, false), at);
    // The kernel's bias is below (r/d)² = .1 %.
    expect_equal(seen, expected, "side " + std::to_string(size.side), 0.001);
  }
}

// The light of a rough mirror is found by sampling the light, too.
TEST(MergeStatistical, SharesSumBehindARoughMirror) {
  for (const float roughness : {0.2f, 0.45f, 0.55f}) {
    const auto scene = floor_before_a_mirror(1, false, roughness);
    const Look at = look(20'000, 400);
    Look many = at;
    many.side = 32;
    expect_equal(seen_by(Method::hybrid, scene, at), seen_by(Method::path, scene, many),
                 "roughness " + std::to_string(roughness), 0.002);
  }
}

Material dark_metal(float roughness) {
  Material metal = mirror(Rgb(kDark));
  metal.roughness = roughness;
  return metal;
}

// A floor of gloss gathers what comes by way of the mirror.
TEST(MergeStatistical, SharesSumOnGloss) {
  Material plastic = lambert(Rgb(kDark));
  plastic.specular = 1;
  plastic.roughness = 0.4f;
  const std::pair<std::string, Material> floors[] = {{"metal", dark_metal(0.45f)}, {"plastic", plastic}};
  for (const auto& [name, floor] : floors) {
    for (const float side : {0.0f, 1e-4f, 0.3f, 0.9f}) {
      Look at = look(60'000, 300);
      at.from = {0.2f, 0.1f, 0.7f};
      at.radius = 0.03f;
      Look many = at;
      many.side = 24;
      const auto mirrored = floor_before_a_mirror(side, false, 0, floor);
      ASSERT_TRUE(mirrored->shares_gloss);
      const Sample expected = seen_by(Method::path, floor_before_a_mirror(side, true, 0, floor), many);
      for (const Method method : {Method::progressive, Method::hybrid}) {
        // The kernel's bias is below (r/(α d))²/12 = .0012: α = .16, d = 1.6.
        expect_equal(seen_by(method, mirrored, at), expected,
                     name + ", side " + std::to_string(side) + ", " + std::string(method_name(method)), 0.0012);
      }
    }
  }
}

// Through the surface of water étendue is diluted by n².
TEST(MergeStatistical, SharesSumBelowWater) {
  Scene scene = empty_scene();
  add_mesh(scene, parallelogram({-3, -3, 0}, {6, 0, 0}, {0, 6, 0}), add_material(scene, lambert(Rgb(kDark))));
  add_mesh(scene, parallelogram({-3, -3, 0.5f}, {6, 0, 0}, {0, 6, 0}), add_material(scene, glass(1.33f)));
  add_mesh(scene, parallelogram({0.5f, -0.7f, 1.2f}, {0, 1.4f, 0}, {1.4f, 0, 0}), add_material(scene, emitter(Rgb(1))));
  const auto pond = prepared(std::move(scene));
  Look at = look(20'000, 300);
  at.from = {1, 0.2f, 0.3f};
  Look many = at;
  many.side = 32;
  expect_equal(seen_by(Method::hybrid, pond, at), seen_by(Method::path, pond, many), "pond", 0.001);
}

// Light from around through a glass ball: of an uneven sky no photon and no path may take it alone; that of an even one
// is the paths', and a lamp's beside it shared as ever.
void expect_equal_under(Environment environment, const Rgb& lamp, const std::string& what,
                        Method method = Method::hybrid, const Material& floor = lambert(Rgb(kDark))) {
  Scene scene = empty_scene();
  add_mesh(scene, parallelogram({-3, -3, 0}, {6, 0, 0}, {0, 6, 0}), add_material(scene, floor));
  add_mesh(scene, sphere({1.2f, 0, 0.6f}, 0.5f, 64), add_material(scene, glass(1.5f)));
  scene.environment = std::move(environment);
  if (!is_black(lamp)) {
    add_mesh(scene, parallelogram({1, -0.2f, 3}, {0, 0.4f, 0}, {0.4f, 0, 0}), add_material(scene, emitter(lamp)));
  }
  const auto ball = prepared(std::move(scene));
  Look at = look(40'000, 500);
  at.radius = 0.02f;   // with .05 the kernel flattens the caustic on gloss by 5 %
  at.from = {1, 0.5f, 0.05f};
  Look many = at;
  many.side = 24;
  expect_equal(seen_by(method, ball, at), seen_by(Method::path, ball, many), what, 0.002);
}

TEST(MergeStatistical, SharesSumUnderAnEnvironment) {
  // One texel near the top that has most of the light, of about 40 degrees: paths find it, too.
  std::vector<Rgb> texels(16 * 8, Rgb(0.05f));
  texels[16 + 8] = Rgb(60);
  const Environment uneven{Rgb(1), std::make_shared<const EnvironmentMap>(16, 8, texels)};
  ASSERT_GT(uneven.concentration(), 20);
  expect_equal_under(uneven, Rgb(0), "uneven sky");
  expect_equal_under({Rgb(1)}, Rgb(0), "even sky");
  expect_equal_under({Rgb(0.3f)}, Rgb(30), "even sky and a lamp");
}

TEST(MergeStatistical, SharesSumOnGlossUnderAnEnvironment) {
  for (const Method method : {Method::progressive, Method::hybrid}) {
    expect_equal_under({Rgb(0.3f)}, Rgb(0), "even sky", method, dark_metal(0.45f));
    expect_equal_under({Rgb(0.3f)}, Rgb(30), "even sky and a lamp", method, dark_metal(0.45f));
  }
}

}  // namespace
}  // namespace photond
