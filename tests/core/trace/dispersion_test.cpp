#include "core/trace/dispersion.h"

#include <gtest/gtest.h>

#include "core/math/rng.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

Material flint() {
  Material m = test::glass(1.62f);
  m.dispersion = 20 / 36.4f;
  return m;
}

TEST(Dispersion, IsThatOfAbbesNumber) {
  EXPECT_NEAR(index_at(flint(), 587.56f), 1.62f, 1e-6f);
  EXPECT_NEAR((1.62f - 1) / (index_at(flint(), 486.13f) - index_at(flint(), 656.27f)), 36.4f, 0.01f);
  Material strange = flint();
  strange.dispersion = 1000;
  EXPECT_GE(index_at(strange, 700), 1);
}

TEST(Dispersion, IsOfSolidGlassOnly) {
  EXPECT_TRUE(disperses(flint()));
  Material thin = flint(), opaque = flint();
  thin.thin_walled = true;
  opaque.transmission = 0;
  EXPECT_FALSE(disperses(thin));
  EXPECT_FALSE(disperses(opaque));
  EXPECT_FALSE(disperses(test::glass(1.62f)));
}

// Means and spreads of the channels' responses, by adding up the observer's curves from 380 to 720 nm by hand
// (responses below zero left out).
TEST(Dispersion, WavelengthsAreThoseOfTheChannels) {
  constexpr int kPasses = 10'000;
  test::Sample seen[3];
  for (std::uint32_t pass = 0; pass < kPasses; ++pass) {
    const Vec3 nm = wavelengths_of_pass(5, pass);
    for (int c = 0; c < 3; ++c) {
      ASSERT_GE(nm[c], 380);
      ASSERT_LE(nm[c], 720);
      seen[c].add(static_cast<double>(nm[c]));
    }
  }
  constexpr double kStep = 0.5;   // nanometres: the program adds up in steps of one
  EXPECT_NEAR(seen[0].mean, 601.24, kStep);
  EXPECT_NEAR(seen[1].mean, 540.67, kStep);
  EXPECT_NEAR(seen[2].mean, 451.83, kStep);
}

// Whatever pass and seed they begin with.
TEST(Dispersion, ConsecutivePassesSpreadEvenly) {
  constexpr std::uint32_t kMany = 1597;   // with which the golden ratio is spread best
  for (const std::uint64_t seed : {0ull, 7ull}) {
    for (const std::uint32_t first : {0u, 1'000'003u}) {
      Vec3 sum{0};
      for (std::uint32_t i = 0; i < kMany; ++i) sum += wavelengths_of_pass(seed, first + i) / static_cast<float>(kMany);
      // Drawn by chance, the mean of so many would be .7 nm off.
      EXPECT_NEAR(sum.y, 540.67f, 0.25f) << seed << " from " << first;
    }
  }
  EXPECT_NE(wavelengths_of_pass(0, 0), wavelengths_of_pass(1, 0));
}

TEST(Dispersion, LeavesOneChannelAndKeepsTheLight) {
  const Scene scene = test::prepared([] {
                        Scene built = test::empty_scene();
                        test::add_mesh(built, test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                                       test::add_material(built, flint()));
                        return built;
                      }())->scene;
  Hit hit;
  hit.t = 1;
  hit.u = hit.v = 0.25f;
  hit.instance = hit.triangle = 0;
  const SurfacePoint met = make_surface(scene, {{0.25f, 0.25f, 1}, {0, 0, -1}}, hit);
  EXPECT_EQ(met.ior, 1.62f);
  const Vec3 nm{620, 540, 460};
  for (const Rgb& light : {Rgb(0.2f, 3, 0.5f), Rgb(0, 2, 0), Rgb(1, 0, 1), Rgb(0, 0, 4)}) {
    test::Sample left[3];
    Rng rng(1, RngPurpose::pilot, 0, 0);
    for (int i = 0; i < 20'000; ++i) {
      SurfacePoint surface = met;
      Rgb one = light;
      disperse(surface, one, nm, i == 0 ? 0x1.fffffep-1f : rng.next());
      const int channel = one.x > 0 ? 0 : one.y > 0 ? 1 : 2;
      ASSERT_EQ(one[channel], light.x + light.y + light.z);
      ASSERT_EQ(one[(channel + 1) % 3] + one[(channel + 2) % 3], 0);
      ASSERT_EQ(surface.ior, index_at(flint(), nm[channel]));
      for (int c = 0; c < 3; ++c) left[c].add(static_cast<double>(one[c]));
    }
    for (int c = 0; c < 3; ++c) EXPECT_TRUE(test::agrees(left[c], static_cast<double>(light[c])));
  }
}

}  // namespace
}  // namespace photond
