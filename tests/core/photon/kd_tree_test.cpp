#include "core/photon/kd_tree.h"

#include <gtest/gtest.h>

#include <set>

#include "core/photon/estimate.h"
#include "core/math/rng.h"
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

class KdTreeQueries : public testing::TestWithParam<std::tuple<int, std::uint32_t>> {};

TEST_P(KdTreeQueries, FixedRadiusEqualsBruteForce) {
  const auto [kind, n] = GetParam();
  const std::vector<Vec3> input = points(kind, n);
  std::vector<std::uint32_t> order;
  const KdTree tree = KdTree::build(input, test::workers().execution(), order);
  ASSERT_EQ(tree.size(), n);
  Rng rng(12, RngPurpose::pilot, 0, 0);
  for (int q = 0; q < 200; ++q) {
    const Vec3 center = n > 0 && q % 2 == 0 ? input[rng.next_uint() % n] : Vec3(rng.next(), rng.next(), rng.next());
    const float radius_sq = 0.3f * rng.next() * rng.next();
    std::multiset<std::uint32_t> found;
    tree.query(center, radius_sq, [&](std::uint32_t i, float d_sq, float&) {
      found.insert(order[i]);
      EXPECT_LT(d_sq, radius_sq);
    });
    std::multiset<std::uint32_t> expected;
    for (std::uint32_t i = 0; i < n; ++i) {
      const float dx = input[i].x - center.x;
      const float dy = input[i].y - center.y;
      const float dz = input[i].z - center.z;
      // As the tree computes it; contraction of the products may differ by a rounding, so ties are left out.
      const float d_sq = dx * dx + dy * dy + dz * dz;
      if (std::abs(d_sq - radius_sq) <= 1e-6f * radius_sq) {
        found.erase(i);
      } else if (d_sq < radius_sq) {
        expected.insert(i);
      }
    }
    EXPECT_EQ(found, expected);
  }
}

TEST_P(KdTreeQueries, NearestEqualsBruteForce) {
  const auto [kind, n] = GetParam();
  std::vector<Photon> photons;
  for (const Vec3& p : points(kind, n)) photons.push_back({p, 0, 0, Rgb(1)});
  const PhotonMap map(photons, test::workers().execution());
  Rng rng(13, RngPurpose::pilot, 0, 0);
  for (const std::uint32_t k : {1u, 5u, 50u}) {
    for (int q = 0; q < 50; ++q) {
      const Vec3 center{rng.next(), rng.next(), rng.next()};
      std::vector<float> distances;
      for (const Photon& p : photons) distances.push_back(glm::dot(p.position - center, p.position - center));
      std::sort(distances.begin(), distances.end());
      const float found = nearest_radius_sq(map, center, k, 1e6f);
      if (n < k) {
        EXPECT_EQ(found, 1e6f);
      } else {
        EXPECT_NEAR(found, distances[k - 1], 1e-5f * found);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Points, KdTreeQueries,
                         testing::Combine(testing::Values(0, 1, 2, 3), testing::Values(0u, 1u, 7u, 12u, 13u, 1000u, 20'000u)));

TEST(KdTree, BitsDoNotDependOnTheThreads) {
  const std::vector<Vec3> input = points(1, 100'000);
  std::vector<std::uint32_t> serial;
  std::vector<std::uint32_t> parallel;
  KdTree::build(input, Execution{}, serial);
  KdTree::build(input, test::workers().execution(), parallel);
  EXPECT_EQ(serial, parallel);
}

TEST(KdTree, NeedsLessThanFifteenBytesAPoint) {
  std::vector<std::uint32_t> order;
  const KdTree tree = KdTree::build(points(0, 100'000), Execution{}, order);
  EXPECT_LT(tree.memory_bytes(), 15 * 100'000u);
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
      photons.push_back({{p.x, p.y, 0}, 0, 0, Rgb(1)});
    }
    const PhotonMap map(photons, Execution{});
    const Vec3 center{0.5f, 0.5f, 0};
    const float radius_sq = nearest_radius_sq(map, center, kNearest, 1);
    double sum = 0;
    map.tree().query(center, radius_sq, [&](std::uint32_t, float d_sq, float&) { sum += epanechnikov(d_sq, radius_sq); });
    kernel.add(sum);
    textbook.add(kNearest / (kPi * radius_sq));
  }
  EXPECT_TRUE(test::agrees(kernel, kPhotons)) << kernel.mean;
  EXPECT_FALSE(test::agrees(textbook, kPhotons));
  EXPECT_NEAR(textbook.mean / kPhotons, 10.0 / 9, 0.02);
}

}  // namespace
}  // namespace photond
