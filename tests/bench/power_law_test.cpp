#include "tests/bench/power_law.h"

#include <gtest/gtest.h>

#include <vector>

namespace photond::bench {
namespace {

TEST(PowerLaw, FindsTheExponent) {
  std::vector<TimePoint> points;
  for (double t = 0.5; t < 100; t *= 1.7) points.push_back({t, 3 * std::pow(t, -0.83)});
  EXPECT_NEAR(fitted_exponent(points).value(), -0.83, 1e-12);   // rounding of some ten doubles
}

TEST(PowerLaw, IsTheLeastSquaresLine) {
  // In powers of e, y = 0, −1, −5 at x = 0, 1, 2: the slope is Σ(x − 1)·y/Σ(x − 1)² = −5/2.
  const std::vector<TimePoint> points = {{1, 1}, {std::exp(1), std::exp(-1)}, {std::exp(2), std::exp(-5)}};
  EXPECT_NEAR(fitted_exponent(points).value(), -2.5, 1e-12);
}

TEST(PowerLaw, NeedsTwoTimes) {
  EXPECT_FALSE(fitted_exponent({}));
  EXPECT_FALSE(fitted_exponent(std::vector<TimePoint>{{2, 1}}));
  EXPECT_FALSE(fitted_exponent(std::vector<TimePoint>{{2, 1}, {2, 3}}));
}

}  // namespace
}  // namespace photond::bench
