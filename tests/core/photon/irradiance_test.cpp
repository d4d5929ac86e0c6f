#include "core/photon/irradiance.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/math/rng.h"
#include "core/math/warp.h"
#include "core/photon/photon_maps.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

constexpr Vec3 kUp{0, 0, 1};

Photon photon(const Vec3& position, const Vec3& normal, const Rgb& flux) {
  return {position, encode_direction(normal), encode_normal(normal), nearest_flux(flux)};
}

// Of one watt each, on the unit square.
PhotonMap on_a_square(int n, Rng& rng) {
  std::vector<Photon> photons;
  for (int i = 0; i < n; ++i) {
    const Vec2 p = rng.next2();
    photons.push_back(photon(Vec3(p, 0), kUp, Rgb(1)));
  }
  return PhotonMap(photons, test::workers().execution());
}

// What the index is to find, looked for among all.
std::optional<std::uint32_t> by_brute_force(const Irradiance& irradiance, const Vec3& position, const Vec3& normal) {
  const PhotonMap& places = irradiance.places();
  std::optional<std::uint32_t> found;
  float nearest = irradiance.reach() * irradiance.reach();
  for (std::uint32_t i = 0; i < places.size(); ++i) {
    const float d = places.leaf(i / PhotonLeaf::kSize).distances_sq(position)[i % PhotonLeaf::kSize];
    if (d >= nearest || glm::dot(places.normal(i), normal) < 0.9f) continue;
    nearest = d;
    found = i;
  }
  return found;
}

// In a cube, crowded in a corner, on a plane, and on nine points: normals of all directions or of six. On a lattice of 1/64
// all squared distances are exact, so of equally near places both find the same.
Vec3 on_lattice(const Vec3& p) { return glm::round(p * 64.0f) / 64.0f; }

class IrradiancePlaces : public testing::TestWithParam<std::tuple<int, std::uint32_t>> {};

TEST_P(IrradiancePlaces, NearestEqualsBruteForce) {
  const auto [kind, n] = GetParam();
  Rng rng(31, RngPurpose::pilot, static_cast<std::uint64_t>(kind), n);
  const auto random_normal = [&] {
    const Vec3 w = square_to_sphere(rng.next2());
    if (kind < 2) return w;
    const int axis = std::min(static_cast<int>(3 * rng.next()), 2);
    Vec3 normal(0);
    normal[axis] = w.x < 0 ? -1.0f : 1.0f;
    return normal;
  };
  std::vector<Photon> photons;
  for (std::uint32_t i = 0; i < n; ++i) {
    Vec3 p = Vec3(rng.next(), rng.next(), rng.next());
    if (kind == 1) p = p * p * p;
    if (kind == 2) p.z = 0.5f;
    if (kind == 3) p = glm::floor(p * 2.99f) * Vec3(0.5f, 0.5f, 0);
    photons.push_back(photon(on_lattice(p), random_normal(), Rgb(1)));
  }
  for (const float reach : {0.05f, 10.0f}) {
    const Irradiance irradiance(PhotonMap(photons, Execution{}), reach);
    for (int q = 0; q < 300; ++q) {
      const Vec3 anywhere = on_lattice(1.2f * Vec3(rng.next(), rng.next(), rng.next()) - 0.1f);
      const bool at_one = n > 0 && q % 3 == 0;
      const Vec3 position = at_one ? photons[rng.next_uint() % n].position : anywhere;
      const Vec3 normal = random_normal();
      EXPECT_EQ(irradiance.nearest(Edges(), position, normal), by_brute_force(irradiance, position, normal));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Places, IrradiancePlaces,
                         testing::Combine(testing::Values(0, 1, 2, 3), testing::Values(0u, 1u, 9u, 1000u, 20'000u)));

// n photons of one watt on the unit square: n W/m², on average over the plane, wherever the nearest place is. At photons'
// own places it would be 3 % more or, without each one's own, .5 % less.
TEST(Irradiance, OfAUniformlyLitPlaneHasNoBias) {
  constexpr int kPhotons = 5000;
  constexpr float kRim = 0.15f;   // twice the radius that holds 64 of them
  test::Sample means;
  for (std::uint64_t run = 0; run < 100; ++run) {
    Rng rng(32, RngPurpose::pilot, run, 0);
    const PhotonMap map = on_a_square(kPhotons, rng), other = on_a_square(kPhotons / 4, rng);
    const PhotonMap* const maps[] = {&map};
    const PhotonMap* const at[] = {&other};
    const Irradiance irradiance(maps, 2, at, Edges(), 1, test::workers().execution());
    EXPECT_EQ(irradiance.places().size(), other.size());
    test::Sample inner;
    for (int q = 0; q < 2000; ++q) {
      const Vec3 position(kRim + (1 - 2 * kRim) * rng.next(), kRim + (1 - 2 * kRim) * rng.next(), 0);
      inner.add(static_cast<double>(irradiance.at(Edges(), position, kUp)->x));
    }
    means.add(inner.mean);
  }
  constexpr double kExpected = kPhotons / 2.0;
  EXPECT_TRUE(test::agrees(means, kExpected)) << means.mean / kExpected << " ± " << means.standard_error() / kExpected;
  EXPECT_LT(means.standard_error(), kExpected / 600) << "precise enough to tell";
}

TEST(Irradiance, ReachesTheEdgeOfAPlane) {
  constexpr int kPhotons = 20'000;
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), test::add_material(scene, test::lambert(Rgb(1))));
  Rng rng(33, RngPurpose::pilot, 0, 0);
  const PhotonMap map = on_a_square(kPhotons, rng), other = on_a_square(kPhotons, rng);
  const PhotonMap* const maps[] = {&map};
  const PhotonMap* const at[] = {&other};
  const auto mean = [&](const Edges& edges) {
    const Irradiance irradiance(maps, 1, at, edges, 1, test::workers().execution());
    test::Sample all;
    for (std::uint32_t i = 0; i < irradiance.places().size(); ++i) {
      all.add(static_cast<double>(irradiance.places().flux(i).x) / kPhotons);
    }
    return all.mean;
  };
  // 32 sectors miss the true edge by up to 1.5 % of what they cut (reach_test).
  EXPECT_NEAR(mean(Edges(scene)), 1, 0.015);
  EXPECT_LT(mean(Edges()), 1 - 0.015) << "dark rims without edges";
}

// A bright half of a floor and a dark one with hardly a photon, with a wall between.
TEST(Irradiance, IsNotReadFromBehindAWall) {
  Scene scene = test::empty_scene();
  const std::uint32_t white = test::add_material(scene, test::lambert(Rgb(1)));
  test::add_mesh(scene, test::parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), white);
  test::add_mesh(scene, test::box({-0.01f, -1, 0}, {0.01f, 1, 1}), white);
  const Edges edges(scene);
  Rng rng(34, RngPurpose::pilot, 0, 0);
  std::vector<Photon> photons;
  for (int i = 0; i < 20'000; ++i) {
    const bool dark = i % 100 == 0;
    const float x = (dark ? 1.0f : -1.0f) * (0.01f + 0.99f * rng.next());
    photons.push_back(photon({x, 2 * rng.next() - 1, 0}, kUp, Rgb(dark ? 1e-3f : 1.0f)));
  }
  const Irradiance irradiance(PhotonMap(photons, Execution{}), 0.5f);
  int across = 0;
  for (int q = 0; q < 500; ++q) {
    const Vec3 position(0.011f + 0.1f * rng.next(), 1.8f * rng.next() - 0.9f, 0);
    const auto place = irradiance.nearest(edges, position, kUp);
    ASSERT_TRUE(place);
    EXPECT_GT(irradiance.places().position(*place).x, 0);
    across += irradiance.places().position(*irradiance.nearest(Edges(), position, kUp)).x < 0 ? 1 : 0;
  }
  EXPECT_GT(across, 100) << "without edges many would be";
}

void expect_same_places(const PhotonMaps& a, const PhotonMaps& b) {
  const auto one = a.irradiance.places().leaves(), other = b.irradiance.places().leaves();
  ASSERT_EQ(one.size(), other.size());
  EXPECT_EQ(std::memcmp(one.data(), other.data(), one.size_bytes()), 0);
}

TEST(Irradiance, OfMapsIsTheSameForAllThreadsAndAddedLater) {
  const auto scene = test::busy_room();
  const PhotonSettings photons{20'000, 3};
  const MapKey key = irradiance_key(scene->digest, photons);
  EXPECT_TRUE(is_irradiance_key(key));
  const auto serial = *build_photon_maps(*scene, key, Execution{});
  const auto parallel = *build_photon_maps(*scene, key, test::workers().execution());
  const auto plain = *build_photon_maps(*scene, {scene->digest, photons, 0}, Execution{});
  const auto added = *add_irradiance(*scene, key, plain, Execution{});
  EXPECT_EQ(plain->irradiance.places().size(), 0u) << "nothing where no key asks for it";
  EXPECT_GT(serial->irradiance.places().size(), 1000u);
  expect_same_places(*serial, *parallel);
  expect_same_places(*serial, *added);
  EXPECT_EQ(added->global.leaves().data(), plain->global.leaves().data()) << "one memory";
  EXPECT_EQ(added->memory_bytes, plain->memory_bytes + added->irradiance.memory_bytes());
}

}  // namespace
}  // namespace photond
