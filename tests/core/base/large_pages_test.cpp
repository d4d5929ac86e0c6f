#include "core/base/large_pages.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <thread>
#include <vector>

#include "core/base/large_array.h"

namespace photond {
namespace {

constexpr std::size_t kMega = std::size_t{1} << 20;

TEST(LargePages, AreAsLargeAsWantedAndAligned) {
  for (const std::size_t bytes : {std::size_t{1}, 2 * kMega, 2 * kMega + 1, 100 * kMega}) {
    const LargePages pages = take_large_pages(bytes);
    EXPECT_GE(pages.bytes, bytes);
    EXPECT_EQ(pages.bytes % kLargePage, 0u);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(pages.memory) % kLargePage, 0u);
    std::memset(pages.memory, 1, pages.bytes);
    give_large_pages(pages);
  }
}

TEST(LargePages, GivenBackAreTakenAgainUnlessTheyAreFarTooLarge) {
  const LargePages first = take_large_pages(20 * kMega);
  give_large_pages(first);
  const LargePages small = take_large_pages(2 * kMega);
  EXPECT_NE(small.memory, first.memory);
  const LargePages again = take_large_pages(18 * kMega);
  EXPECT_EQ(again.memory, first.memory);
  EXPECT_EQ(again.bytes, first.bytes);
  give_large_pages(again);
  give_large_pages(small);
}

TEST(LargePages, OfThoseGivenBackTheLatestAreKeptUpTo64MB) {
  std::vector<LargePages> many;
  for (int i = 0; i < 10; ++i) many.push_back(take_large_pages(16 * kMega));
  for (const LargePages& pages : many) give_large_pages(pages);
  std::vector<LargePages> again;
  for (int i = 0; i < 4; ++i) again.push_back(take_large_pages(16 * kMega));
  for (int i = 0; i < 4; ++i) EXPECT_EQ(again[i].memory, many[9 - i].memory);
  for (const LargePages& pages : again) give_large_pages(pages);
}

TEST(LargePages, ManyThreadsHaveEachTheirOwn) {
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([t] {
      for (int i = 0; i < 50; ++i) {
        const auto array = make_large_array<int>(kMega);
        array[0] = array[kMega - 1] = t * 1000 + i;
        std::this_thread::yield();
        EXPECT_EQ(array[0], t * 1000 + i);
        EXPECT_EQ(array[kMega - 1], t * 1000 + i);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace photond
