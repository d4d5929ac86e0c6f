#include "core/trace/emission_pattern.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/math/warp.h"
#include "core/trace/prepare.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

constexpr std::uint32_t kSide = 8;

// One bright cell in the middle, one at a corner, others dim or black.
EmissionPattern pattern() {
  std::vector<float> radiance(kSide * kSide, 0);
  for (std::size_t i = 0; i < radiance.size(); ++i) radiance[i] = i % 3 == 0 ? 0.1f : 0;
  radiance[3 * kSide + 4] = 30;
  radiance.back() = 7;
  return {kSide, radiance};
}

TEST(EmissionPattern, DrawsPlacesWithTheDensityItTells) {
  constexpr std::uint32_t kFine = 4 * kSide;
  constexpr int kDraws = 400'000;
  const EmissionPattern places = pattern();
  std::vector<double> observed(kFine * kFine), expected(kFine * kFine);
  Rng rng(1, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < kDraws; ++i) {
    const EmissionPattern::Place place = places.draw(rng.next2());
    const Vec2 cell = glm::min(place.u * float{kFine}, Vec2(kFine - 1));
    ++observed[static_cast<std::uint32_t>(cell.y) * kFine + static_cast<std::uint32_t>(cell.x)];
  }
  for (std::uint32_t i = 0; i < kFine * kFine; ++i) {
    const Vec2 middle = (Vec2(i % kFine, i / kFine) + 0.5f) / float{kFine};
    expected[i] = kDraws * static_cast<double>(places.density(middle)) / (kFine * kFine);
  }
  EXPECT_GT(test::chi2_test(observed, expected), test::kSignificance);
}

TEST(EmissionPattern, TellsOfAPlaceWhatWasDrawn) {
  const EmissionPattern places = pattern();
  Rng rng(2, RngPurpose::pilot, 0, 0);
  int differ = 0;
  for (int i = 0; i < 10'000; ++i) {
    const EmissionPattern::Place place = places.draw(rng.next2());
    differ += places.density(place.u) != place.density;
  }
  EXPECT_LE(differ, 2);   // at the border of a cell
}

TEST(EmissionPattern, DrawsEverywhere) {
  const EmissionPattern places = pattern();
  for (const float x : {0.0f, 0.3f, 1.0f}) {
    for (const float y : {0.0f, 0.6f, 1.0f}) EXPECT_GT(places.density({x, y}), 0.05f);
  }
}

TEST(EmissionPattern, IsNoneWhereAllCellsAreAlike) {
  EXPECT_TRUE(EmissionPattern().even());
  EXPECT_TRUE(EmissionPattern(2, std::vector<float>{1, 1.1f, 0.9f, 1}).even());
  EXPECT_TRUE(EmissionPattern(2, std::vector<float>{0, 0, 0, 0}).even());
  EXPECT_FALSE(EmissionPattern(2, std::vector<float>{0, 1, 0, 0}).even());
  EXPECT_EQ(EmissionPattern().density({0.2f, 0.3f}), 1);
}

constexpr int kTexels = 64, kLit = 3;   // the latter along each side of a square of them
constexpr float kRadiance = 200;

// Lamps on which a few of many texels shine; `twice`: the mesh is placed twice, once mirrored.
Scene pictures(bool twice) {
  Scene scene = test::empty_scene();
  TextureImage image;
  image.width = image.height = kTexels;
  image.u8.assign(4 * kTexels * kTexels, 0);
  for (int y = 10; y < 10 + kLit; ++y) {
    for (int x = 40; x < 40 + kLit; ++x) {
      for (int c = 0; c < 4; ++c) image.u8[static_cast<std::size_t>(4 * (y * kTexels + x) + c)] = 255;
    }
  }
  scene.images.push_back(image);
  Texture texture;
  texture.nearest = true;
  scene.textures.push_back(texture);
  Material picture = test::emitter(Rgb(kRadiance));
  picture.emission_texture.texture = 0;
  test::add_mesh(scene, test::parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), test::add_material(scene, picture));
  if (twice) {
    Instance mirrored = scene.instances.back();
    mirrored.to_world = Affine(-1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5f, 2.5f, 0.1f);
    scene.instances.push_back(mirrored);
  }
  return scene;
}

class Pictures : public testing::TestWithParam<bool> {
 protected:
  std::shared_ptr<const PreparedScene> prepared_ = test::prepared(pictures(GetParam()));
  Lights lights_{prepared_->scene, prepared_->bounds};   // that may shine on nothing
  double power_ = (GetParam() ? 2 : 1) * static_cast<double>(kPi) * 4 * kRadiance * kLit * kLit / (kTexels * kTexels);
};
INSTANTIATE_TEST_SUITE_P(, Pictures, testing::Bool(), [](const auto& pictures) -> std::string {
  return pictures.param ? "PlacedTwice" : "Placed";
});

// By looks at the texels, of which those at the rim of what shines count in part.
TEST_P(Pictures, HaveTheirPower) { EXPECT_NEAR(lights_.total_power() / power_, 1, 0.05); }

// Of a point that is met as of one that is sampled.
TEST_P(Pictures, TellTheDensityThatSamplesHave) {
  const Vec3 point{0.3f, -0.2f, 1.1f};
  Rng rng(3, RngPurpose::pilot, 0, 0);
  int differ = 0, seen = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec2 u = rng.next2();
    const DirectSample s = lights_.sample_direct(prepared_->scene, point, {u, rng.next()});
    const Hit hit = prepared_->accel.intersect({point, s.wi});
    if (!hit.found()) continue;   // by an edge
    ++seen;
    const SurfacePoint met = make_surface(prepared_->scene, {point, s.wi}, hit);
    constexpr float kRounding = 1e-4f;   // of the distance and of cosines near the plane
    differ += std::abs(lights_.pdf_direct(prepared_->scene, met, s.wi, hit.t) / s.pdf_w - 1) > kRounding;
  }
  EXPECT_GT(seen, 950);
  EXPECT_LE(differ, 5);   // by the border of a cell or of a triangle the next one is met
}

// As much light as by the geometry of the bright square, with about the noise of an even lamp as small.
TEST_P(Pictures, LightAPointAsLampsOfTheirBrightPartsDo) {
  const Vec3 point{0.3f, -0.2f, 3};
  const test::Sample sampled = test::draw(100'000, [&](Rng& rng) {
    const Vec2 u = rng.next2();
    return static_cast<double>(lights_.sample_direct(prepared_->scene, point, {u, rng.next()}).radiance.x);
  });
  const auto solid_angle = [&](const Vec3& middle) {   // of the small square, to a thousandth
    constexpr double kArea = 4.0 * kLit * kLit / (kTexels * kTexels);
    const glm::dvec3 way = glm::dvec3(middle) - glm::dvec3(point);
    return kArea * std::abs(way.z) / std::pow(glm::length(way), 3);
  };
  const Vec3 bright{-1 + 2 * 41.5f / kTexels, -1 + 2 * 11.5f / kTexels, 0};
  double expected = solid_angle(bright);
  if (GetParam()) expected += solid_angle(transform_point(prepared_->scene.instances[1].to_world, bright));
  expected *= static_cast<double>(kRadiance);
  EXPECT_NEAR(sampled.mean, expected, test::kSigmas * sampled.standard_error() + 1e-3 * expected);
  // Drawn evenly, one in 455 places shines: 21 times the mean.
  EXPECT_LT(sampled.standard_error() * std::sqrt(1e5) / sampled.mean, 1.5);
}

TEST_P(Pictures, EmitTheirPowerWithoutNoise) {
  const test::Sample flux = test::draw(100'000, [&](Rng& rng) {
    return static_cast<double>(lights_.sample_emission(prepared_->scene, rng).flux.x);
  });
  EXPECT_TRUE(test::agrees(flux, power_)) << flux.mean << " of " << power_;
  EXPECT_LT(flux.standard_error() * std::sqrt(1e5) / flux.mean, 1);   // 21, drawn evenly
}

TEST_P(Pictures, TellTheEtendueThatPathsHave) {
  Rng rng(4, RngPurpose::pilot, 0, 0);
  int differ = 0, seen = 0;
  for (int i = 0; i < 1000; ++i) {
    const EmissionSample s = lights_.sample_emission(prepared_->scene, rng);
    const Ray back{s.ray.origin + 1e-3f * s.ray.direction, -s.ray.direction};
    const Hit hit = prepared_->accel.intersect(back);
    if (!hit.found()) continue;   // by an edge
    ++seen;
    const float told = lights_.etendue(prepared_->scene, make_surface(prepared_->scene, back, hit), s.ray.direction);
    differ += std::abs(told / s.etendue - 1) > 1e-5f;
  }
  EXPECT_GT(seen, 900);
  EXPECT_LE(differ, 5);   // by the border of a cell or of a triangle the next one is met
}

// Of what no number tells where it is on the texture, and of a radiance at the end of what a float holds.
TEST(PicturesAtTheLimits, HaveAPower) {
  Scene scene = pictures(false);
  scene.materials[0].emission = Rgb(3e38f);
  EXPECT_TRUE(std::isfinite(test::prepared(scene)->lights.total_power()));
  for (const float u : {std::numeric_limits<float>::quiet_NaN(), kInfinity}) {
    for (Vec2& uv : scene.meshes[0].uv[0]) uv = {u, -u};
    const auto prepared = test::prepared(scene);
    EXPECT_EQ(prepared->lights.total_power(), 0) << "they read as the first texel, which is black";
    EXPECT_TRUE(prepared->lights.shines_evenly(0));
  }
}

}  // namespace
}  // namespace photond
