#include "core/photon/photon_maps.h"

#include <gtest/gtest.h>

#include "core/photon/radius.h"
#include "core/photon/shoot.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

MapKey key(std::uint32_t photons, std::uint32_t pass = 0) {
  MapKey k;
  k.settings.photons_per_pass = photons;
  k.pass = pass;
  return k;
}

// Emission is drawn in proportion to power, so the mean flux of the paths is the total power.
TEST(PhotonMaps, EmitsThePowerOfTheLights) {
  const auto scene = test::busy_room();
  test::Sample emitted;
  for (std::uint32_t pass = 0; pass < 30; ++pass) {
    emitted.add((*build_photon_maps(*scene, key(5000, pass), test::workers().execution()))->ledger.emitted);
  }
  EXPECT_TRUE(test::agrees(emitted, scene->lights.total_power())) << emitted.mean << " " << scene->lights.total_power();
}

TEST(PhotonMaps, BitsDoNotDependOnTheThreads) {
  const auto scene = test::busy_room();
  const auto serial = *build_photon_maps(*scene, key(20'000), Execution{});
  const auto parallel = *build_photon_maps(*scene, key(20'000), test::workers().execution());
  ASSERT_EQ(serial->global.size(), parallel->global.size());
  ASSERT_EQ(serial->caustic.size(), parallel->caustic.size());
  EXPECT_GT(serial->caustic.size(), 100u);
  for (std::uint32_t i = 0; i < serial->global.size(); ++i) {
    ASSERT_EQ(serial->global.position(i), parallel->global.position(i));
    ASSERT_EQ(serial->global.flux(i), parallel->global.flux(i));
    ASSERT_EQ(serial->global.direction(i), parallel->global.direction(i));
  }
  EXPECT_EQ(serial->ledger.absorbed, parallel->ledger.absorbed);
}

TEST(PhotonMaps, PassesDiffer) {
  const auto scene = test::busy_room();
  const auto a = *build_photon_maps(*scene, key(2000, 0), Execution{});
  const auto b = *build_photon_maps(*scene, key(2000, 1), Execution{});
  EXPECT_NE(a->ledger.absorbed, b->ledger.absorbed);
}

TEST(PhotonMaps, CancelledBuildsSaySo) {
  const auto scene = test::busy_room();
  std::stop_source stop;
  stop.request_stop();
  const auto maps = build_photon_maps(*scene, key(1'000'000), test::workers().execution(stop.get_token()));
  ASSERT_FALSE(maps.ok());
  EXPECT_EQ(maps.error().code, ErrorCode::cancelled);
}

// Every way light takes to a wall through a lossless mirror is a caustic, every way off a wall is not.
TEST(PhotonMaps, TellsCausticsFromTheRest) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::parallelogram({-5, -5, 0}, {10, 0, 0}, {0, 10, 0}),
                 test::add_material(scene, test::lambert(Rgb(0.5f))));
  test::add_mesh(scene, test::parallelogram({-5, -5, 2}, {10, 0, 0}, {0, 10, 0}),
                 test::add_material(scene, test::mirror(Rgb(1))));
  test::add_point_light(scene, {0, 0, 1}, Rgb(1));
  const auto prepared = test::prepared(std::move(scene));
  const auto maps = *build_photon_maps(*prepared, key(10'000), Execution{});
  ASSERT_GT(maps->caustic.size(), 1000u);
  ASSERT_GT(maps->global.size(), 1000u);
  for (std::uint32_t i = 0; i < maps->caustic.size(); ++i) EXPECT_NEAR(maps->caustic.position(i).z, 0, 1e-5f);
  // The mirror image is a point light at height 3, half of whose flux goes down: E(0) = I/9.
  const double flux_to_floor = 0.5 * 4 * kPi;
  double flux = 0;
  for (std::uint32_t i = 0; i < maps->caustic.size(); ++i) flux += maps->caustic.flux(i).x / 10'000;
  EXPECT_LT(flux, flux_to_floor);
}

// Closed mesh: rays from inside never get out.
TEST(PhotonMaps, ClosedSphereDoesNotLeak) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::sphere({1000, 0, 0}, 1, 64), test::add_material(scene, test::lambert(Rgb(0.5f))));
  test::add_point_light(scene, {1000, 0, 0}, Rgb(1));
  const auto maps = *build_photon_maps(*test::prepared(std::move(scene)), key(100'000), test::workers().execution());
  EXPECT_LT(maps->ledger.escaped / maps->ledger.emitted, 1e-5);
}

TEST(Radius, ClosedFormFollowsTheRecurrence) {
  double factor = 1;
  for (std::uint32_t pass = 0; pass < 2000; ++pass) {
    EXPECT_NEAR(radius_sq_factor(pass), factor, 1e-9 * factor);
    const double i = pass + 1;
    factor *= (i + kRadiusAlpha) / (i + 1);
  }
}

}  // namespace
}  // namespace photond
