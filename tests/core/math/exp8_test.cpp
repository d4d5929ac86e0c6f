#include "core/math/exp8.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/math/rng.h"

namespace photond {
namespace {

TEST(Exp8, LogarithmsAndPowersAreThoseOfOne) {
  Rng rng(1, RngPurpose::pilot, 0, 0);
  for (int round = 0; round < 10'000; ++round) {
    Float8 power, value;
    for (int k = 0; k < 8; ++k) {
      power[k] = 250 * rng.next() - 125;
      value[k] = std::exp2(250 * rng.next() - 125);
    }
    const Float8 powers = exp2_8(power), logarithms = log2_8(value);
    for (int k = 0; k < 8; ++k) {
      ASSERT_NEAR(powers[k] / std::exp2(power[k]), 1, 4e-7f) << power[k];
      ASSERT_NEAR(logarithms[k], std::log2(value[k]), 2e-7f * std::abs(std::log2(value[k])) + 1e-7f) << value[k];
    }
  }
}

TEST(Exp8, MeetsWholeNumbers) {
  for (int n = -126; n <= 126; ++n) {
    EXPECT_EQ(exp2_8(Float8{} + static_cast<float>(n))[3], std::ldexp(1.0f, n));
    EXPECT_EQ(log2_8(Float8{} + std::ldexp(1.0f, n))[3], static_cast<float>(n));
  }
  EXPECT_EQ(exp2_8(Float8{} - 1000)[0], std::ldexp(1.0f, -126));
}

}  // namespace
}  // namespace photond
