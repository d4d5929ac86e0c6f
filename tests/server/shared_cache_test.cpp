#include "server/jobs/shared_cache.h"

#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <string>
#include <thread>

namespace photond {
namespace {

struct Thing {
  int id = 0;
  std::uint64_t memory_bytes = 0;
};
using Cache = SharedCache<std::string, Thing>;

Result<Cache::Shared> thing(int id, std::uint64_t bytes) {
  return std::make_shared<const Thing>(Thing{id, bytes});
}

/// Asks for `key` with a builder that must not be needed.
bool is_cached(Cache& cache, const std::string& key) {
  const auto answer = cache.get_or_build(
      key, [] { return thing(-1, 0); }, {}, false);
  return answer->hit;
}

void wait_for(const std::atomic<int>& value, int expected) {
  while (value < expected) std::this_thread::yield();
}

TEST(SharedCache, FindsWhatWasBuilt) {
  Cache cache(100);
  const auto first = cache.get_or_build("a", [] { return thing(1, 10); }, {});
  const auto second = cache.get_or_build("a", [] { return thing(2, 10); }, {});
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_FALSE(first->hit);
  EXPECT_TRUE(second->hit);
  EXPECT_EQ(second->value->id, 1);
  const auto totals = cache.totals();
  EXPECT_EQ(totals.hits, 1u);
  EXPECT_EQ(totals.misses, 1u);
  EXPECT_EQ(totals.bytes, 10u);
}

TEST(SharedCache, DropsTheLeastRecentlyUsedBeyondTheBudget) {
  Cache cache(100);
  for (const char* key : {"a", "b", "c"}) (void)cache.get_or_build(key, [] { return thing(1, 30); }, {});
  EXPECT_TRUE(is_cached(cache, "a"));
  const auto held = cache.get_or_build("b", [] { return thing(9, 1); }, {});
  (void)cache.get_or_build("a", [] { return thing(9, 1); }, {});
  (void)cache.get_or_build("d", [] { return thing(1, 30); }, {});
  EXPECT_FALSE(is_cached(cache, "c")) << "the oldest";
  EXPECT_TRUE(is_cached(cache, "a"));
  EXPECT_TRUE(is_cached(cache, "b"));
  (void)cache.get_or_build("e", [] { return thing(1, 100); }, {});
  EXPECT_EQ(cache.totals().entries, 1u);
  EXPECT_EQ(cache.totals().bytes, 100u);
  EXPECT_EQ(held->value->id, 1) << "eviction must not take values from their users";
}

TEST(SharedCache, HandsOutButDoesNotKeepWhatExceedsTheBudget) {
  Cache cache(100);
  const auto big = cache.get_or_build("a", [] { return thing(7, 101); }, {});
  ASSERT_TRUE(big.ok());
  EXPECT_EQ(big->value->id, 7);
  EXPECT_FALSE(is_cached(cache, "a"));
  EXPECT_EQ(cache.totals().bytes, 0u);
}

TEST(SharedCache, BuildsOnceForManyAtTheSameTime) {
  Cache cache(100);
  std::atomic<int> builds = 0, asking = 0, hits = 0;
  const auto build = [&] {
    wait_for(asking, 32);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return thing(++builds, 10);
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < 32; ++i) {
    threads.emplace_back([&] {
      ++asking;
      const auto answer = cache.get_or_build("a", build, {});
      ASSERT_TRUE(answer.ok());
      EXPECT_EQ(answer->value->id, 1);
      hits += answer->hit;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(builds, 1);
  EXPECT_EQ(hits, 31);
}

TEST(SharedCache, AWaiterBuildsWhereTheBuilderIsCancelled) {
  Cache cache(100);
  std::atomic<int> building = 0, release = 0;
  std::thread builder([&] {
    const auto answer = cache.get_or_build("a",
                                           [&]() -> Result<Cache::Shared> {
                                             ++building;
                                             wait_for(release, 1);
                                             return cancelled();
                                           },
                                           {});
    EXPECT_FALSE(answer.ok());
  });
  wait_for(building, 1);
  std::atomic<int> rebuilt = 0;
  std::vector<std::thread> waiters;
  for (int i = 0; i < 4; ++i) {
    waiters.emplace_back([&] {
      const auto answer = cache.get_or_build("a", [&] { return thing(++rebuilt, 10); }, {});
      ASSERT_TRUE(answer.ok());
      EXPECT_EQ(answer->value->id, 1);
    });
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  ++release;
  builder.join();
  for (std::thread& waiter : waiters) waiter.join();
  EXPECT_EQ(rebuilt, 1);
}

TEST(SharedCache, WaitersGetTheBuildersErrorAndTheNextOneTriesAgain) {
  Cache cache(100);
  const auto failed =
      cache.get_or_build("a", []() -> Result<Cache::Shared> { return invalid_input("bad"); }, {});
  ASSERT_FALSE(failed.ok());
  EXPECT_EQ(failed.error().message, "bad");
  EXPECT_TRUE(cache.get_or_build("a", [] { return thing(1, 1); }, {}).ok());
}

TEST(SharedCache, ABuilderThatThrowsLeavesNobodyWaiting) {
  Cache cache(100);
  std::atomic<int> building = 0, release = 0;
  std::thread builder([&] {
    const auto throwing = [&]() -> Result<Cache::Shared> {
      ++building;
      wait_for(release, 1);
      throw std::bad_alloc();
    };
    EXPECT_THROW((void)cache.get_or_build("a", throwing, {}), std::bad_alloc);
  });
  wait_for(building, 1);
  std::stop_source patience;
  std::thread waiter([&] {
    const auto answer = cache.get_or_build("a", [] { return thing(1, 1); }, patience.get_token());
    ASSERT_FALSE(answer.ok());
    EXPECT_EQ(answer.error().code, ErrorCode::internal);
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  ++release;
  builder.join();
  std::jthread end_of_patience([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    patience.request_stop();
  });
  waiter.join();
  const auto again = cache.get_or_build("a", [] { return thing(1, 1); }, patience.get_token());
  EXPECT_TRUE(again.ok()) << "and it may be tried again";
}

TEST(SharedCache, AWaiterLeavesWhenItsOwnTokenAsks) {
  Cache cache(100);
  std::atomic<int> building = 0, release = 0;
  std::thread builder([&] {
    (void)cache.get_or_build("a",
                             [&] {
                               ++building;
                               wait_for(release, 1);
                               return thing(1, 1);
                             },
                             {});
  });
  wait_for(building, 1);
  std::stop_source stop;
  std::thread waiter([&] {
    const auto answer = cache.get_or_build(
        "a", [] { return thing(2, 1); }, stop.get_token());
    ASSERT_FALSE(answer.ok());
    EXPECT_EQ(answer.error().code, ErrorCode::cancelled);
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  stop.request_stop();
  waiter.join();
  ++release;
  builder.join();
}

TEST(SharedCache, ForgetsOnRequest) {
  Cache cache(100);
  (void)cache.get_or_build("a", [] { return thing(1, 10); }, {});
  EXPECT_TRUE(cache.erase("a"));
  EXPECT_FALSE(cache.erase("a"));
  EXPECT_EQ(cache.totals().bytes, 0u);
  EXPECT_TRUE(cache.list().empty());
}

TEST(SharedCache, DoesNotKeepWhereAskedNotTo) {
  Cache cache(100);
  const auto answer = cache.get_or_build(
      "a", [] { return thing(1, 10); }, {}, false);
  EXPECT_FALSE(answer->hit);
  EXPECT_FALSE(is_cached(cache, "a"));
}

}  // namespace
}  // namespace photond
