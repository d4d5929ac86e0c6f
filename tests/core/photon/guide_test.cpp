#include "core/photon/guide.h"

#include <gtest/gtest.h>

#include "tests/support/scenes.h"

namespace photond {
namespace {

TEST(GatherGuide, IsSharedByAllSettingsWithEnoughPhotons) {
  const Digest scene{};
  EXPECT_EQ(guide_key(scene, {262'144, 1}), guide_key(scene, {1'000'000, 1}));
  EXPECT_NE(guide_key(scene, {262'144, 1}), guide_key(scene, {262'144, 2}));
  EXPECT_NE(guide_key(scene, {262'144, 1}), guide_key(scene, {1000, 1}));
  EXPECT_TRUE(is_guide_key(guide_key(scene, {1000, 1})));
  EXPECT_FALSE(is_guide_key({scene, {1000, 1}, 0}));
  EXPECT_EQ(pilot_share({262'144, 0}), 0.125f);
  EXPECT_EQ(pilot_share({1000, 0}), 1);
}

// Eight times the photons in a pass are in a radius whose square is an eighth.
TEST(GatherGuide, TheShareOfThePilotScalesDensities) {
  const auto scene = test::busy_room();
  const auto guide = *build_gather_guide(*scene, guide_key(scene->digest, {2000, 0}), Execution{});
  ASSERT_GT(guide->global.densities().size(), 0u);
  const Vec3 p = guide->pilot->global.position(7);
  EXPECT_FLOAT_EQ(guide->global.radius_sq(p, 150 * 0.125f), guide->global.radius_sq(p, 150) / 8);
  EXPECT_GT(guide->memory_bytes, guide->pilot->memory_bytes);
}

}  // namespace
}  // namespace photond
