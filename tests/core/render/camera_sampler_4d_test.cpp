#include "core/render/camera_sampler.h"

#include <gtest/gtest.h>

namespace photond {
namespace {

TEST(CameraSampler4d, IsTwoPairs) {
  CameraSampler pairs(3, 5, 1234), fours(3, 5, 1234);
  // An odd start, so that one of the fours ends beyond the stratified dimensions.
  EXPECT_EQ(pairs.next2(), fours.next2());
  for (int i = 0; i < 40; ++i) {
    const Vec2 xy = pairs.next2();
    const Vec2 zw = pairs.next2();
    EXPECT_EQ(fours.next4(), Vec4(xy, zw)) << i;
  }
}

}  // namespace
}  // namespace photond
