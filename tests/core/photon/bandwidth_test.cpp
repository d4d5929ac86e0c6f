#include "core/photon/bandwidth.h"

#include <gtest/gtest.h>

#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

std::shared_ptr<const PhotonMaps> floor_map(int count, std::uint64_t seed) {
  std::vector<Photon> photons;
  Rng rng(seed, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < count; ++i) {
    const Vec2 u = rng.next2();
    // Half of them on [0, 1/2], half on the four times larger rest.
    photons.push_back({{u.x < 0.5f ? u.x : 0.5f + 4 * (u.x - 0.5f), u.y, 0}, 0, 0, nearest_flux(Rgb(1))});
  }
  auto maps = std::make_shared<PhotonMaps>();
  maps->global = PhotonMap(photons, Execution{});
  return maps;
}

TEST(Bandwidth, HoldsThePhotonsAskedFor) {
  constexpr float kPhotons = 20;
  constexpr int kCount = 20'000;
  const auto maps = floor_map(kCount, 1);
  const Bandwidth bandwidth(maps, &maps->global, Execution{});
  for (const auto& [from, to, density] : {std::tuple(0.1f, 0.4f, 1.0f), std::tuple(0.7f, 2.3f, 0.25f)}) {
    test::Sample inverse;
    Rng rng(2, RngPurpose::pilot, 0, 0);
    for (int i = 0; i < 2000; ++i) {
      const Vec3 p(from + (to - from) * rng.next(), 0.1f + 0.8f * rng.next(), 0);
      inverse.add(kPhotons / kPi / bandwidth.radius_sq(p, kPhotons) / (kCount * density));
    }
    // A photon counts itself among its neighbours, +7 %; random points are nearest to photons that stand alone, about
    // as much less. 2000 points that share their photons are as good as some 600 with a spread of 1/√14: 1.1 %.
    EXPECT_NEAR(inverse.mean, 1, 0.1) << density;
  }
}

TEST(Bandwidth, SaysNothingWithoutPhotons) {
  const auto empty = floor_map(0, 1);
  EXPECT_EQ(Bandwidth().radius_sq({0, 0, 0}, 150), 0);
  EXPECT_EQ(Bandwidth(empty, &empty->global, {}).radius_sq({0, 0, 0}, 150), 0);
}

TEST(Bandwidth, SaysNothingOfAHandfulOfPhotons) {
  const auto few = floor_map(15, 1), enough = floor_map(16, 1);
  EXPECT_EQ(Bandwidth(few, &few->global, {}).radius_sq({0.5f, 0.5f, 0}, 150), 0);
  EXPECT_GT(Bandwidth(enough, &enough->global, {}).radius_sq({0.5f, 0.5f, 0}, 150), 0);
}

/// Photons in one place: a radius, however small, never a division by zero.
TEST(Bandwidth, CoincidentPhotonsHaveARadius) {
  auto maps = std::make_shared<PhotonMaps>();
  maps->global = PhotonMap(std::vector<Photon>(100, Photon{{1, 2, 3}, 0, 0, nearest_flux(Rgb(1))}), Execution{});
  const float r_sq = Bandwidth(maps, &maps->global, Execution{}).radius_sq({1, 2, 3}, 150);
  EXPECT_TRUE(std::isfinite(r_sq));
  EXPECT_GT(r_sq, 0);
}

TEST(Bandwidth, DoesNotDependOnTheThreads) {
  const auto maps = floor_map(5000, 3);
  const Bandwidth one(maps, &maps->global, Execution{}), many(maps, &maps->global, test::workers().execution());
  Rng rng(4, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < 500; ++i) {
    const Vec3 p(2.5f * rng.next(), rng.next(), 0);
    EXPECT_EQ(one.radius_sq(p, 150), many.radius_sq(p, 150));
  }
}

}  // namespace
}  // namespace photond
