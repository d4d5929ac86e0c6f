#include "core/math/sobol.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "tests/support/statistics.h"

namespace photond {
namespace {

constexpr std::uint64_t kFirstSeeds = 20;

/// Every aligned block of 2^k samples has one in each of the 2^k intervals of every shape 2^−i × 2^(i−k).
TEST(Sobol, EveryBlockFillsTheElementaryIntervals) {
  for (std::uint64_t seed = 0; seed < kFirstSeeds; ++seed) {
    for (const std::uint32_t k : {1u, 2u, 4u, 5u, 8u}) {
      for (const std::uint32_t block : {0u, 1u, 6u, 1000u}) {
        for (std::uint32_t i = 0; i <= k; ++i) {
          std::set<std::uint32_t> cells;
          for (std::uint32_t n = 0; n < 1u << k; ++n) {
            const Vec2 u = sobol_2d((block << k) + n, mix64(seed));
            const auto column = static_cast<std::uint32_t>(std::ldexp(u.x, static_cast<int>(i)));
            const auto row = static_cast<std::uint32_t>(std::ldexp(u.y, static_cast<int>(k - i)));
            cells.insert(column << (k - i) | row);
          }
          ASSERT_EQ(cells.size(), 1u << k) << "seed " << seed << ", block " << block << ", shape " << i;
        }
      }
    }
  }
}

/// A sample of a given index is uniform over the seeds.
TEST(Sobol, IsUniformOverTheSeeds) {
  constexpr int kCells = 8, kSeeds = 64'000;
  for (const std::uint32_t index : {0u, 1u, 7u, 12'345u}) {
    std::vector<double> observed(kCells * kCells), expected(kCells * kCells, 1.0 * kSeeds / kCells / kCells);
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const Vec2 u = sobol_2d(index, mix64(seed + 1));
      ASSERT_TRUE(u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1);
      ++observed[static_cast<std::size_t>(u.x * kCells) * kCells + static_cast<std::size_t>(u.y * kCells)];
    }
    EXPECT_GT(test::chi2_test(observed, expected), test::kSignificance) << index;
  }
}

/// Two dimensions of sequences whose seeds differ fill their common square evenly: their orders are independent too.
TEST(Sobol, SequencesOfOtherSeedsAreIndependent) {
  constexpr int kCells = 8, kSeeds = 4000, kIndices = 16;
  std::vector<double> observed(kCells * kCells), expected(kCells * kCells, 1.0 * kSeeds * kIndices / kCells / kCells);
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    for (std::uint32_t i = 0; i < kIndices; ++i) {
      const float x = sobol_2d(i, mix64(2 * seed)).x, y = sobol_2d(i, mix64(2 * seed + 1)).x;
      ++observed[static_cast<std::size_t>(x * kCells) * kCells + static_cast<std::size_t>(y * kCells)];
    }
  }
  // The sixteen pairs of a seed are less even in the product than in x or y alone, never more uneven than chance.
  EXPECT_GT(test::chi2_test(observed, expected), test::kSignificance);
}

/// A smooth integrand: scrambled nets have a variance of order n^−3 instead of 1/n [Owen 1997].
TEST(Sobol, IntegratesSmoothFunctionsFarBetterThanMonteCarlo) {
  constexpr std::uint32_t kSamples = 16;
  test::Sample net, random;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    double a = 0, b = 0;
    Rng rng(seed, RngPurpose::pilot, 0, 0);
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      const Vec2 u = sobol_2d(i, mix64(seed)), v = rng.next2();
      a += std::exp(u.x + u.y) / kSamples;
      b += std::exp(v.x + v.y) / kSamples;
    }
    net.add(a);
    random.add(b);
  }
  const double truth = std::pow(std::exp(1.0) - 1, 2);
  EXPECT_TRUE(test::agrees(net, truth)) << net.mean;
  EXPECT_TRUE(test::agrees(random, truth)) << random.mean;
  // n² = 256 times less is the order of magnitude; a tenth of it is asked for.
  EXPECT_LT(net.m2 * 25, random.m2) << random.m2 / net.m2;
}

TEST(Sobol, FourDimensionsAreTwoPairs) {
  for (std::uint32_t i = 0; i < 100; ++i) {
    const std::uint64_t a = mix64(i), b = mix64(a);
    const Vec4 four = sobol_4d(i, a, b);
    EXPECT_EQ(Vec2(four), sobol_2d(i, a));
    EXPECT_EQ(Vec2(four.z, four.w), sobol_2d(i, b));
  }
}

}  // namespace
}  // namespace photond
