#include "core/photon/photon_maps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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

// A mirror on a floor in the open, or in a black box, where all paths meet something.
std::shared_ptr<const PreparedScene> mirror_on_floor(bool in_box) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::parallelogram({-2, 0, -2}, {0, 0, 4}, {4, 0, 0}),
                 test::add_material(scene, test::lambert(Rgb(0.5f))));
  test::add_mesh(scene, test::sphere({0, 0.9f, 0}, 0.8f), test::add_material(scene, test::mirror(Rgb(0.9f))));
  test::add_mesh(scene, test::parallelogram({2, 4, 1}, {0.4f, 0, 0}, {0, 0.1f, 0.4f}),
                 test::add_material(scene, test::emitter(Rgb(10))));
  if (in_box) {
    test::add_mesh(scene, test::box({-20, -20, -20}, {20, 20, 20}, true),
                   test::add_material(scene, test::lambert(Rgb(0))));
  }
  return test::prepared(std::move(scene));
}

TEST(PhotonMaps, OfDirectedPathsHoldTheSameLight) {
  const auto open = mirror_on_floor(false), box = mirror_on_floor(true);
  ASSERT_TRUE(open->domain.active);
  ASSERT_TRUE(open->aim.active);
  EXPECT_LT(open->directed_share, 0.7);
  EXPECT_FALSE(box->domain.active);
  const auto flux = [](const PhotonMap& map, double emitted) {
    double sum = 0;
    for (std::uint32_t i = 0; i < map.size(); ++i) {
      if (glm::length(map.position(i)) < 4) sum += static_cast<double>(map.flux(i).x);
    }
    return sum / emitted;
  };
  test::Sample emitted;
  test::Sample caustic[2], global[2];
  for (std::uint32_t pass = 0; pass < 30; ++pass) {
    for (const auto& scene : {open, box}) {
      const auto maps = *build_photon_maps(*scene, key(20'000, pass), test::workers().execution());
      EXPECT_EQ(maps->emitted, std::ceil(20'000 * scene->directed_share));
      const EnergyLedger& l = maps->ledger;
      EXPECT_NEAR(l.absorbed + l.escaped + l.truncated + l.rejected, l.emitted, 1e-5 * l.emitted);
      caustic[scene == box].add(flux(maps->caustic, maps->emitted));
      global[scene == box].add(flux(maps->global, maps->emitted));
      if (scene == open) emitted.add(l.emitted);
    }
  }
  for (const test::Sample* part : {caustic, global}) {
    const double error = std::hypot(part[0].standard_error(), part[1].standard_error());
    EXPECT_LT(error, 0.05 * part[1].mean);
    EXPECT_NEAR(part[0].mean, part[1].mean, test::kSigmas * error);
  }
  EXPECT_TRUE(test::agrees(emitted, open->lights.total_power())) << emitted.mean << " " << open->lights.total_power();
}

// What is rejected is told as that alone, whether or not paths are directed.
TEST(PhotonMaps, LightTooStrongForAFloatIsRejected) {
  for (const float side : {0.1f, 4.0f}) {
    Scene scene = test::empty_scene();
    test::add_mesh(scene, test::parallelogram({-2, 0, -2}, {0, 0, 4}, {4, 0, 0}),
                   test::add_material(scene, test::lambert(Rgb(0.5f))));
    test::add_mesh(scene, test::parallelogram({-side / 2, 0.1f, -side / 2}, {side, 0, 0}, {0, 0, side}),
                   test::add_material(scene, test::emitter(Rgb(kInfinity))));
    const auto maps = *build_photon_maps(*test::prepared(std::move(scene)), key(100), Execution{});
    EXPECT_EQ(maps->ledger.rejected, std::numeric_limits<double>::infinity()) << side;
    EXPECT_EQ(maps->ledger.escaped, 0) << side;
  }
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

// A lamp in a white box with a glass ball; the box is open to the sky.
std::shared_ptr<const PreparedScene> glass_ball_under(Rgb sky) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::box({-2, -2, 0}, {2, 2, 3}, true), test::add_material(scene, test::lambert(Rgb(0.5f))));
  scene.meshes[0].triangles.resize(10);
  test::add_mesh(scene, test::sphere({0, 0, 0.6f}, 0.5f, 32), test::add_material(scene, test::glass(1.5f)));
  test::add_point_light(scene, {0, 0, 2}, Rgb(1));
  scene.environment.radiance = sky;
  return test::prepared(std::move(scene));
}

TEST(PhotonMaps, TheCausticSetHasTheCausticsOfAllPhotonsAndNothingElse) {
  const auto scene = glass_ball_under(Rgb(0));
  MapKey caustic = key(20'000);
  caustic.set = PhotonSet::caustic;
  const auto all = *build_photon_maps(*scene, key(20'000), test::workers().execution());
  const auto some = *build_photon_maps(*scene, caustic, test::workers().execution());
  EXPECT_EQ(some->global.size(), 0u);
  EXPECT_EQ(some->rays, all->caustic_rays);
  EXPECT_LT(some->rays, all->rays);
  EXPECT_EQ(some->emitted, all->emitted);
  ASSERT_EQ(some->caustic.size(), all->caustic.size());
  for (std::uint32_t i = 0; i < some->caustic.size(); ++i) {
    ASSERT_EQ(some->caustic.position(i), all->caustic.position(i));
    // Rounded at random to 1/256.
    ASSERT_NEAR(some->caustic.flux(i).x, all->caustic.flux(i).x, all->caustic.flux(i).x / 128);
    ASSERT_EQ(some->caustic.direction(i), all->caustic.direction(i));
  }
  const EnergyLedger& l = some->ledger;
  EXPECT_NEAR(l.absorbed + l.escaped + l.truncated + l.rejected, l.emitted, 1e-6 * l.emitted);
}

// A sky that casts no caustics emits no photon there, and the lamps lose none of their power.
TEST(PhotonMaps, TheCausticSetLeavesAnEvenSkyOut) {
  const auto lamp = glass_ball_under(Rgb(0)), both = glass_ball_under(Rgb(1));
  EXPECT_FALSE(both->lights.environment_casts());
  test::Sample emitted, caustic, alone;
  const auto flux = [](const PhotonMaps& maps) {
    double sum = 0;
    for (std::uint32_t i = 0; i < maps.caustic.size(); ++i) sum += static_cast<double>(maps.caustic.flux(i).x);
    return sum / maps.emitted;
  };
  for (std::uint32_t pass = 0; pass < 40; ++pass) {
    MapKey k = key(5000, pass);
    k.set = PhotonSet::caustic;
    const auto maps = *build_photon_maps(*both, k, test::workers().execution());
    emitted.add(maps->ledger.emitted);
    caustic.add(flux(*maps));
    alone.add(flux(**build_photon_maps(*lamp, k, test::workers().execution())));
  }
  EXPECT_NEAR(emitted.mean, lamp->lights.total_power(), 1e-5 * emitted.mean);   // sums of floats
  const double error = std::hypot(caustic.standard_error(), alone.standard_error());
  EXPECT_LT(error, 0.02 * alone.mean);
  EXPECT_NEAR(caustic.mean, alone.mean, 4 * error);
}

// The sky's chance is nearly all there is, and no photon of it is wanted.
TEST(PhotonMaps, ALampThatShinesPastEverythingHoldsNothingUp) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::parallelogram({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}), test::add_material(scene, test::lambert(Rgb(0.5f))));
  test::add_mesh(scene, test::sphere({0, 0, 0.6f}, 0.5f, 32), test::add_material(scene, test::glass(1.5f)));
  test::add_mesh(scene, test::parallelogram({0, 0, 2}, {1, 0, 0}, {0, 1, 0}), test::add_material(scene, test::emitter(Rgb(3))));
  scene.environment.radiance = Rgb(1);
  const auto room = test::prepared(std::move(scene));
  EXPECT_GT(room->lights.casting_share(), 0);
  EXPECT_LT(room->lights.casting_share(), 1e-4);
  MapKey k = key(20'000);
  k.set = PhotonSet::caustic;
  const auto maps = *build_photon_maps(*room, k, test::workers().execution());
  EXPECT_NEAR(maps->ledger.emitted, 3 * static_cast<double>(kPi), 1e-3);
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
