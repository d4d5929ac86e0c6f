#include "core/render/camera_sampler.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "core/film/film.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

static_assert(kStratifiedPasses == kBlockPasses, "a film takes the means of these passes for independent");

TEST(CameraSampler, DependsOnNothingButItsArguments) {
  CameraSampler a(1, 20, 3), b(1, 20, 3), other_seed(2, 20, 3), other_pass(1, 21, 3), other_pixel(1, 20, 4);
  for (int i = 0; i < 100; ++i) {
    const Vec2 u = a.next2();
    EXPECT_EQ(u, b.next2());
    EXPECT_NE(u, other_seed.next2());
    EXPECT_NE(u, other_pass.next2());
    EXPECT_NE(u, other_pixel.next2());
  }
}

/// Pairs of numbers are stratified over a block, in both dimensions and in the plane.
TEST(CameraSampler, StratifiesThePassesOfABlock) {
  for (const std::uint32_t block : {0u, 5u}) {
    std::vector<CameraSampler> passes;
    for (std::uint32_t i = 0; i < kStratifiedPasses; ++i) passes.emplace_back(7, block * kStratifiedPasses + i, 11);
    for (int pair = 0; pair < 24; ++pair) {
      std::set<int> columns, rows, cells;
      for (CameraSampler& sampler : passes) {
        const Vec2 u = sampler.next2();
        columns.insert(static_cast<int>(16 * u.x));
        rows.insert(static_cast<int>(16 * u.y));
        cells.insert(static_cast<int>(4 * u.x) * 4 + static_cast<int>(4 * u.y));
      }
      EXPECT_EQ(columns.size(), 16u) << pair;
      EXPECT_EQ(rows.size(), 16u) << pair;
      EXPECT_EQ(cells.size(), 16u) << pair;
    }
  }
}

/// χ² of two streams' values in their common square.
void expect_independent(const char* what, CameraSampler (*first)(std::uint64_t), CameraSampler (*second)(std::uint64_t)) {
  constexpr int kCells = 8;
  constexpr std::uint64_t kStreams = 3000;
  std::vector<double> observed(kCells * kCells), expected(kCells * kCells, 1.0 * kStreams * 40 / kCells / kCells);
  for (std::uint64_t n = 0; n < kStreams; ++n) {
    CameraSampler a = first(n), b = second(n);
    for (int dimension = 0; dimension < 40; ++dimension) {
      const float x = a.next(), y = b.next();
      ++observed[static_cast<std::size_t>(x * kCells) * kCells + static_cast<std::size_t>(y * kCells)];
    }
  }
  EXPECT_GT(test::chi2_test(observed, expected), test::kSignificance) << what;
}

TEST(CameraSampler, BlocksAndPixelsAreIndependent) {
  const auto base = [](std::uint64_t n) { return CameraSampler(1, 3, n); };
  expect_independent("blocks", base, [](std::uint64_t n) { return CameraSampler(1, 3 + kStratifiedPasses, n); });
  expect_independent("pixels", base, [](std::uint64_t n) { return CameraSampler(1, 3, n + 1); });
  expect_independent("seeds", base, [](std::uint64_t n) { return CameraSampler(2, 3, n); });
}

TEST(CameraSampler, FourNumbersAreTwoPairs) {
  CameraSampler pairs(3, 5, 1234), fours(3, 5, 1234);
  EXPECT_EQ(pairs.next2(), fours.next2());
  for (int i = 0; i < 40; ++i) {
    const Vec2 xy = pairs.next2();
    const Vec2 zw = pairs.next2();
    EXPECT_EQ(fours.next4(), Vec4(xy, zw)) << i;
  }
}

TEST(CameraSampler, BranchesAreIndependentOfWhatTheyLeave) {
  expect_independent("branch", [](std::uint64_t n) { return CameraSampler(1, 3, n); },
                     [](std::uint64_t n) { return CameraSampler(1, 3, n).branch(); });
  CameraSampler sampler(1, 3, 5);
  CameraSampler first = sampler.branch(), second = sampler.branch();
  EXPECT_NE(first.next2(), second.next2());
}

}  // namespace
}  // namespace photond
