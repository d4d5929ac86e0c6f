#include "core/base/trial.h"

#include <gtest/gtest.h>

#include <csignal>
#include <stdexcept>

namespace photond {
namespace {

TEST(Trial, TellsWhatEnds) {
  int seen = 0;
  EXPECT_TRUE(ends_within(1, [&] { seen = 1; }));
  EXPECT_EQ(seen, 0) << "it was a copy that did it";
  EXPECT_TRUE(ends_within(1, [] { throw std::runtime_error("also an end"); }));
  EXPECT_FALSE(ends_within(1, [] { std::raise(SIGKILL); }));
}

TEST(Trial, EndsWhatTakesTooLong) {
  volatile bool forever = true;
  EXPECT_FALSE(ends_within(1, [&] {
    while (forever) {
    }
  }));
}

}  // namespace
}  // namespace photond
