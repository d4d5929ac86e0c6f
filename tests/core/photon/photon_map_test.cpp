#include "core/photon/photon_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "core/photon/nearest.h"
#include "core/math/rng.h"
#include "tests/support/estimate.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

// Uniform, clustered, coplanar and coincident points.
std::vector<Vec3> points(int kind, std::uint32_t n) {
  std::vector<Vec3> result;
  Rng rng(11, RngPurpose::pilot, static_cast<std::uint64_t>(kind), n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const float x = rng.next();
    const float y = rng.next();
    const float z = rng.next();
    if (kind == 0) result.push_back({x, y, z});
    if (kind == 1) result.push_back({x * x * x * x, 100 + y * y * y, z < 0.5f ? 0.0f : 1e-4f * z});
    if (kind == 2) result.push_back({x, 0.25f, y});
    if (kind == 3) result.push_back({0.5f, std::floor(y * 3), 0.5f});
  }
  return result;
}

// Photons whose flux is their number, which the map's rounding keeps up to 511.
std::vector<Photon> photons_at(const std::vector<Vec3>& positions) {
  std::vector<Photon> photons;
  for (const Vec3& p : positions) photons.push_back({p, 0, 0, nearest_flux(Rgb(static_cast<float>(photons.size())))});
  return photons;
}

// The positions within the radius, as the index finds them.
std::vector<Vec3> found(const PhotonMap& map, const Vec3& center, float radius_sq) {
  std::vector<Vec3> result;
  map.tree().query(center, radius_sq, [&](std::span<const std::uint32_t> leaves) {
    for (const std::uint32_t leaf : leaves) {
      const auto d = map.leaf(leaf).distances_sq(center);
      for (std::uint32_t i = 0; i < PhotonLeaf::kSize; ++i) {
        if (d[i] < radius_sq) result.push_back(map.position(leaf * PhotonLeaf::kSize + i));
      }
    }
  });
  return result;
}

bool before(const Vec3& a, const Vec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

class PhotonMapQueries : public testing::TestWithParam<std::tuple<int, std::uint32_t>> {};

// On a lattice of 1/64 all squared distances are exact, so the sets are equal to the last photon on the rim.
TEST_P(PhotonMapQueries, FixedRadiusEqualsBruteForce) {
  const auto [kind, n] = GetParam();
  std::vector<Vec3> input = points(kind, n);
  for (Vec3& p : input) p = glm::round(p * 64.0f) / 64.0f;
  const PhotonMap map(photons_at(input), test::workers().execution());
  ASSERT_EQ(map.size(), n);
  Rng rng(12, RngPurpose::pilot, 0, 0);
  for (int q = 0; q < 200; ++q) {
    const Vec3 anywhere = glm::round(64.0f * Vec3(rng.next(), rng.next(), rng.next())) / 64.0f;
    const Vec3 center = n > 0 && q % 2 == 0 ? input[rng.next_uint() % n] : anywhere;
    const float radius_sq = std::round(1000 * rng.next() * rng.next()) / 4096;
    std::vector<Vec3> expected;
    for (const Vec3& p : input) {
      if (glm::dot(p - center, p - center) < radius_sq) expected.push_back(p);
    }
    std::vector<Vec3> result = found(map, center, radius_sq);
    std::sort(expected.begin(), expected.end(), before);
    std::sort(result.begin(), result.end(), before);
    ASSERT_EQ(result, expected);
  }
}

// The same for arbitrary coordinates, but for photons whose distance rounds to the radius.
TEST_P(PhotonMapQueries, FixedRadiusFindsAllOfArbitraryPoints) {
  const auto [kind, n] = GetParam();
  const std::vector<Vec3> input = points(kind, n);
  const PhotonMap map(photons_at(input), test::workers().execution());
  Rng rng(12, RngPurpose::pilot, 1, 0);
  for (int q = 0; q < 100; ++q) {
    const Vec3 center(rng.next(), rng.next() + (kind == 1 ? 100 : 0), rng.next());
    const float radius_sq = 0.3f * rng.next() * rng.next();
    // Two roundings of each of three products.
    const auto count = [&](float factor) {
      return std::count_if(input.begin(), input.end(), [&](const Vec3& p) {
        return glm::dot(glm::dvec3(p - center), glm::dvec3(p - center)) < factor * radius_sq;
      });
    };
    const auto result = static_cast<std::ptrdiff_t>(found(map, center, radius_sq).size());
    ASSERT_GE(result, count(1 - 1e-6f));
    ASSERT_LE(result, count(1 + 1e-6f));
  }
}

TEST_P(PhotonMapQueries, NearestEqualsBruteForce) {
  const auto [kind, n] = GetParam();
  const std::vector<Photon> photons = photons_at(points(kind, n));
  const PhotonMap map(photons, test::workers().execution());
  Rng rng(13, RngPurpose::pilot, 0, 0);
  for (const std::uint32_t k : {1u, 5u, 50u, kMaxNearest}) {
    for (int q = 0; q < 50; ++q) {
      const Vec3 center{rng.next(), rng.next(), rng.next()};
      std::vector<float> distances;
      for (const Photon& p : photons) distances.push_back(glm::dot(p.position - center, p.position - center));
      std::sort(distances.begin(), distances.end());
      for (const float max_radius_sq : {1e6f, 0.01f}) {
        const float result = nearest_radius_sq(map, center, k, max_radius_sq);
        const float expected = n < k ? max_radius_sq : std::min(max_radius_sq, distances[k - 1]);
        // The products of one distance may be contracted differently.
        EXPECT_NEAR(result, expected, 1e-6f * expected);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Points, PhotonMapQueries,
                         testing::Combine(testing::Values(0, 1, 2, 3), testing::Values(0u, 1u, 7u, 8u, 9u, 1000u, 20'000u)));

void expect_equal(const PhotonMap& a, const PhotonMap& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a.position(i), b.position(i));
    ASSERT_EQ(a.flux(i), b.flux(i));
    ASSERT_EQ(a.direction(i), b.direction(i));
  }
}

TEST(PhotonMap, BitsDoNotDependOnTheThreadsNorOnTheBlocks) {
  std::vector<Photon> photons = photons_at(points(1, 100'000));
  for (Photon& photon : photons) photon.flux = nearest_flux(photon.position);
  const PhotonMap serial(photons, Execution{});
  expect_equal(serial, PhotonMap(photons, test::workers().execution()));
  const std::span<const Photon> all(photons);
  Bounds3 bounds;
  for (const Photon& photon : photons) bounds.add(photon.position);
  PhotonCells uneven(bounds);
  for (const auto part : {all.first(3), all.first(0), all.subspan(3, 50'000), all.subspan(50'003)}) uneven.append(part);
  expect_equal(serial, PhotonMap(std::move(uneven), false, test::workers().execution()));
}

TEST(PhotonMap, KeepsEveryPhoton) {
  for (const int kind : {0, 1, 2, 3}) {
    const std::vector<Photon> photons = photons_at(points(kind, 511));
    const PhotonMap map(photons, Execution{});
    std::vector<float> seen;
    for (std::uint32_t i = 0; i < map.size(); ++i) {
      seen.push_back(map.flux(i).x);
      ASSERT_EQ(map.position(i), photons[static_cast<std::size_t>(seen.back())].position);
    }
    std::sort(seen.begin(), seen.end());
    for (std::size_t i = 0; i < seen.size(); ++i) ASSERT_EQ(seen[i], static_cast<float>(i));
  }
}

TEST(PhotonMap, KeepsAllThatAPhotonIs) {
  std::vector<Photon> photons = photons_at(points(0, 509));
  for (std::uint32_t i = 0; i < photons.size(); ++i) {
    photons[i].direction = 0x10000 * i + 1;
    photons[i].normal = 0x20000000 + i;
    photons[i].flux = nearest_flux({static_cast<float>(i), static_cast<float>(i % 7), static_cast<float>(i % 11)});
    photons[i].etendue = static_cast<float>(i) + 0.5f;
  }
  PhotonCells cells({Vec3(0), Vec3(1)});
  cells.append(photons);
  const PhotonMap map(std::move(cells), true, Execution{});
  for (std::uint32_t i = 0; i < map.size(); ++i) {
    const PhotonLeaf& leaf = map.leaf(i / PhotonLeaf::kSize);
    const std::uint32_t k = i % PhotonLeaf::kSize;
    const std::uint32_t number = map.normal_bits(i) - 0x20000000;
    ASSERT_LT(number, photons.size());
    EXPECT_EQ(map.position(i), photons[number].position);
    EXPECT_EQ(leaf.direction[k], photons[number].direction);
    for (int c = 0; c < 3; ++c) EXPECT_EQ(leaf.flux[c][k], photons[number].flux[c]);
    EXPECT_EQ(map.etendues(i / PhotonLeaf::kSize)[k], photons[number].etendue);
  }
}

TEST(PhotonMap, NeedsLessThanThirtyBytesAPhoton) {
  const PhotonMap map(photons_at(points(0, 100'000)), Execution{});
  EXPECT_LT(map.memory_bytes(), 30 * 100'000u);
}

// E[Σ kernel] over the k nearest of uniform points is the density [hard cases, row 29]; counting the k-th photon in
// a box kernel would give k/(k−1) of it, and must be seen to fail here.
TEST(NearestEstimate, IsUnbiasedOnUniformDensity) {
  constexpr std::uint32_t kPhotons = 2000;
  constexpr std::uint32_t kNearest = 10;
  test::Sample kernel;
  test::Sample textbook;
  for (std::uint64_t trial = 0; trial < 4000; ++trial) {
    Rng rng(14, RngPurpose::pilot, 0, trial);
    std::vector<Photon> photons;
    for (std::uint32_t i = 0; i < kPhotons; ++i) {
      const Vec2 p = rng.next2();
      photons.push_back({{p.x, p.y, 0}, 0, 0, nearest_flux(Rgb(1))});
    }
    const PhotonMap map(photons, Execution{});
    const Vec3 center{0.5f, 0.5f, 0};
    const float radius_sq = nearest_radius_sq(map, center, kNearest, 1);
    double sum = 0;
    for (const Vec3& p : found(map, center, radius_sq)) sum += test::epanechnikov(glm::dot(p - center, p - center), radius_sq);
    kernel.add(sum);
    textbook.add(kNearest / (kPi * radius_sq));
  }
  EXPECT_TRUE(test::agrees(kernel, kPhotons)) << kernel.mean;
  EXPECT_FALSE(test::agrees(textbook, kPhotons));
  EXPECT_NEAR(textbook.mean / kPhotons, 10.0 / 9, 0.02);
}

}  // namespace
}  // namespace photond
