#include "core/trace/plain.h"

#include <gtest/gtest.h>

#include <memory>

#include "core/math/octahedral.h"
#include "core/trace/prepare.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

const Rgb kAlbedo{0.8f, 0.5f, 0.1f};

std::shared_ptr<const PreparedScene> floor_of(const Material& material) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), test::add_material(scene, material));
  return test::prepared(std::move(scene));
}

// A batch of photons of `flux` that fall onto the floor from above (1) or below (−1).
void fall(PlainBounces& bounces, const PreparedScene& scene, float side, const Rgb& flux, Rng& rng) {
  const Ray ray{{0.3f, -0.2f, side}, glm::normalize(Vec3(-0.1f, 0.4f, -side))};
  const Hit hit = scene.accel.intersect(ray);
  ASSERT_TRUE(hit.found());
  for (std::uint32_t k = 0; k < kLanes; ++k) {
    bounces.set(k, scene.placed[hit.instance], hit, ray.direction, flux, 1, rng);
  }
  bounces.scatter(kLanes);
}

TEST(Plain, IsWhatNeedsNeitherTextureNorNormalNorLayer) {
  const auto is_plain = [](const Material& m) { return floor_of(m)->placed[0].plain; };
  EXPECT_TRUE(is_plain(test::lambert(kAlbedo)));
  EXPECT_FALSE(is_plain(test::lambert(Rgb(0))));  // nothing to reflect
  EXPECT_FALSE(is_plain(test::mirror(Rgb(1))));
  EXPECT_FALSE(is_plain(test::glass(1.5f)));
  Material layered = test::lambert(kAlbedo);
  layered.specular = 1;
  EXPECT_FALSE(is_plain(layered));
  Scene smooth = test::empty_scene();
  test::add_mesh(smooth, test::sphere({0, 0, 0}, 1, 4), test::add_material(smooth, test::lambert(kAlbedo)));
  EXPECT_FALSE(test::prepared(std::move(smooth))->placed[0].plain);
}

TEST(Plain, DirectionsAreCosineDistributedOnTheSideOfThePhoton) {
  const auto scene = floor_of(test::lambert(kAlbedo));
  for (const float side : {1.0f, -1.0f}) {
    const auto bounces = std::make_unique<PlainBounces>();
    std::uint32_t next = kLanes;
    const auto sample = [&](Rng& rng) {
      if (next == kLanes) {
        fall(*bounces, *scene, side, Rgb(1), rng);
        next = 0;
      }
      return bounces->next_direction[next++];
    };
    EXPECT_GT(test::chi2_sphere(sample, [&](const Vec3& w) { return std::max(0.0f, side * w.z) * kInvPi; }),
              test::kSignificance);
  }
}

// The survivors carry the albedo's share of the flux on average, and each the power of the brightest channel.
TEST(Plain, RouletteKeepsTheFlux) {
  const auto scene = floor_of(test::lambert(kAlbedo));
  const Rgb flux{1, 2, 3};
  Rng rng(5, RngPurpose::pilot, 0, 0);
  const auto bounces = std::make_unique<PlainBounces>();
  test::Sample red, green, blue;
  for (int i = 0; i < 2000; ++i) {
    fall(*bounces, *scene, 1, flux, rng);
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      const Rgb next = bounces->next_flux[k];
      red.add(next.x);
      green.add(next.y);
      blue.add(next.z);
      EXPECT_NEAR(bounces->next_power[k], (next.x + next.y + next.z) / 3, 1e-6f * 3);  // a few roundings of 3
      EXPECT_GT(glm::dot(decode_normal(bounces->normal[k]), Vec3(0, 0, 1)), 0.99f);
    }
  }
  EXPECT_TRUE(test::agrees(red, flux.x * kAlbedo.x));
  EXPECT_TRUE(test::agrees(green, flux.y * kAlbedo.y));
  EXPECT_TRUE(test::agrees(blue, flux.z * kAlbedo.z));
}

}  // namespace
}  // namespace photond
