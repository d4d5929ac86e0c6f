#include "server/http/crew.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>

namespace photond {
namespace {

TEST(Crew, RunsAsManyTasksAtOnceAsItMayAndNoMore) {
  Crew crew(3);
  std::latch all(3), go(1);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(crew.start([&] {
      all.count_down();
      go.wait();
    }));
  }
  EXPECT_FALSE(crew.start([] {}));
  all.wait();
  go.count_down();
}

TEST(Crew, IdleThreadsServeAgain) {
  Crew crew(2);
  std::atomic<int> done = 0;
  int started = 0;
  while (started < 1000) started += crew.start([&] { ++done; }) ? 1 : 0;
  crew.stop();
  EXPECT_EQ(done, 1000) << "what was accepted is done";
  EXPECT_FALSE(crew.start([] {}));
}

}  // namespace
}  // namespace photond
