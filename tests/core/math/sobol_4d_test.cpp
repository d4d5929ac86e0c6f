#include <gtest/gtest.h>

#include "core/math/sobol.h"

namespace photond {
namespace {

TEST(Sobol4d, IsTwoPairs) {
  for (std::uint32_t i = 0; i < 100; ++i) {
    const std::uint64_t a = mix64(i), b = mix64(a);
    const Vec4 four = sobol_4d(i, a, b);
    EXPECT_EQ(Vec2(four), sobol_2d(i, a));
    EXPECT_EQ(Vec2(four.z, four.w), sobol_2d(i, b));
  }
}

}  // namespace
}  // namespace photond
