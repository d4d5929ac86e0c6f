#include "core/math/grid_distribution.h"

#include <gtest/gtest.h>

#include "core/math/rng.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

TEST(GridDistribution, DrawsCellsByWeight) {
  const std::vector<float> weights = {0, 1, 2, 0, 0, 0, 5, 0.5f, 0.25f, 3, 0, 1};
  const GridDistribution grid(3, 4, weights);
  std::vector<double> observed(weights.size()), expected(weights.size());
  constexpr int kDraws = 200'000;
  Rng rng(1, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < kDraws; ++i) {
    const GridDistribution::Place place = grid.sample(rng.next2());
    ++observed[place.y * 3 + place.x];
    ASSERT_EQ(place.probability, grid.probability(place.x, place.y));
    ASSERT_TRUE(place.s >= 0 && place.s <= 1 && place.t >= 0 && place.t <= 1);
  }
  double sum = 0;
  for (std::uint32_t i = 0; i < weights.size(); ++i) {
    const double probability = grid.probability(i % 3, i / 3);
    // A unit of 2⁻²⁴ in each of the two functions.
    EXPECT_NEAR(probability, static_cast<double>(weights[i]) / 12.75, 2e-7);
    EXPECT_EQ(probability > 0, weights[i] > 0);
    expected[i] = probability * kDraws;
    sum += probability;
  }
  EXPECT_NEAR(sum, 1, 1e-6);
  EXPECT_GT(test::chi2_test(observed, expected), test::kSignificance);
}

// What rounding would lose: a cell of 10⁻³⁰ of the weight is drawn by the numbers that are its own.
TEST(GridDistribution, ForgetsNoLitCell) {
  std::vector<float> weights(4096 * 3, 1e-30f);
  weights[5000] = 1;
  weights[7] = 0;
  const GridDistribution grid(4096, 3, weights);
  for (std::uint32_t i = 0; i < weights.size(); ++i) {
    ASSERT_EQ(grid.probability(i % 4096, i / 4096) > 0, weights[i] > 0) << i;
  }
  EXPECT_EQ(grid.sample({0, 0}).x, 0u);
  EXPECT_EQ(grid.sample({0x1.fffffep-1f, 0x1.fffffep-1f}).x, 4095u);
  const GridDistribution::Place place = grid.sample({0.5f, 0.5f});
  EXPECT_EQ(place.y * 4096 + place.x, 5000u);
}

TEST(GridDistribution, NeverDrawsADarkEnd) {
  const GridDistribution grid(4, 3, std::vector<float>{0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0});
  for (const float u : {0.0f, 0x1p-24f, 0.5f, 0x1.fffffep-1f}) {
    const GridDistribution::Place place = grid.sample({u, u});
    EXPECT_EQ(place.y, 1u);
    EXPECT_EQ(place.x, u < 0.5f ? 1u : 2u);
  }
}

}  // namespace
}  // namespace photond
