#include "server/jobs/map_cache.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include "server/store/map_key_text.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

namespace photond {
namespace {

namespace fs = std::filesystem;
using Origin = MapCache::Origin;

class MapCacheTest : public ::testing::Test {
 protected:
  void SetUp() override {
    scene_ = test::busy_room();
    open();
  }

  void open(std::uint64_t memory = 1 << 30, std::uint64_t disk = 1 << 30) {
    cache_.reset();
    auto files = MapFiles::open(folder_.path(), disk);
    ASSERT_TRUE(files.ok());
    cache_ = std::make_unique<MapCache>(memory, std::move(*files));
  }
  MapKey key(std::uint32_t pass, std::uint32_t photons = 2000) const { return {scene_->digest, {photons, 0}, pass}; }
  MapKey of_guide() const { return guide_key(scene_->digest, {2000, 0}); }
  Origin origin(const MapKey& k, bool keep = true) {
    const auto answer = cache_->get(*scene_, k, Execution{}, keep);
    EXPECT_TRUE(answer.ok());
    return answer->origin;
  }
  std::uint64_t bytes(std::uint32_t pass) {
    return (*cache_->get(*scene_, key(pass), Execution{}, false)).value->memory_bytes;
  }

  test::TemporaryFolder folder_;
  std::shared_ptr<const PreparedScene> scene_;
  std::unique_ptr<MapCache> cache_;
};

TEST_F(MapCacheTest, FindsMapsAndGuidesAfterARestart) {
  EXPECT_EQ(origin(key(0)), Origin::built);
  EXPECT_EQ(origin(of_guide()), Origin::built);
  EXPECT_EQ(origin(key(0)), Origin::memory);
  const auto built = cache_->get(*scene_, key(0), Execution{}, true)->value;
  open();   // finishes writing first
  EXPECT_EQ(origin(key(0)), Origin::disk);
  EXPECT_EQ(origin(of_guide()), Origin::disk);
  EXPECT_EQ(origin(key(0)), Origin::memory);
  EXPECT_EQ(origin(key(1)), Origin::built);
  const auto found = cache_->get(*scene_, key(0), Execution{}, true)->value;
  ASSERT_EQ(found->maps->global.size(), built->maps->global.size());
  EXPECT_EQ(std::memcmp(found->maps->global.leaves().data(), built->maps->global.leaves().data(),
                        built->maps->global.leaves().size_bytes()), 0);
  EXPECT_EQ(found->facts.build_seconds, built->facts.build_seconds);
  const auto totals = cache_->totals();
  EXPECT_EQ(totals.disk_hits, 2u);
  EXPECT_EQ(totals.memory.hits, 2u);
  EXPECT_EQ(totals.misses, 1u);
}

TEST_F(MapCacheTest, IrradianceIsAddedToPhotonsThatAreThere) {
  const MapKey irradiance = irradiance_key(scene_->digest, {2000, 0});
  EXPECT_EQ(origin(irradiance), Origin::built);
  EXPECT_FALSE(cache_->find(key(0))) << "nobody asked for them alone";
  EXPECT_EQ(origin(irradiance), Origin::memory);
  const std::uint64_t alone = cache_->find(irradiance)->bytes;
  EXPECT_EQ(cache_->totals().memory.bytes, alone);
  open();
  EXPECT_EQ(origin(irradiance), Origin::disk);
  EXPECT_TRUE(cache_->erase(irradiance));
  EXPECT_EQ(origin(key(0)), Origin::built);
  EXPECT_EQ(origin(irradiance), Origin::built);
  const auto plain = cache_->get(*scene_, key(0), Execution{}, true)->value->maps;
  const auto with = cache_->get(*scene_, irradiance, Execution{}, true)->value->maps;
  EXPECT_EQ(with->global.leaves().data(), plain->global.leaves().data());
  EXPECT_GT(with->irradiance.places().size(), 0u);
  EXPECT_EQ(cache_->find(irradiance)->bytes, alone) << "counted in full: the other may be forgotten first";
}

TEST_F(MapCacheTest, WhatIsNotKeptIsNotWritten) {
  EXPECT_EQ(origin(key(0), false), Origin::built);
  ASSERT_TRUE(cache_->flush());
  EXPECT_TRUE(cache_->list().empty());
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST_F(MapCacheTest, WhatIsNotKeptIsFoundOnDiskAllTheSame) {
  EXPECT_EQ(origin(key(0)), Origin::built);
  open();
  EXPECT_EQ(origin(key(0), false), Origin::disk);
  EXPECT_EQ(origin(key(0), false), Origin::disk) << "and not kept in memory";
}

TEST_F(MapCacheTest, DamagedFilesAreBuiltAgain) {
  (void)origin(key(0));
  (void)origin(of_guide());
  open();
  for (const auto& entry : fs::directory_iterator(folder_.path())) {
    const auto middle = static_cast<std::streamoff>(fs::file_size(entry.path()) / 2);
    std::fstream file(entry.path(), std::ios::binary | std::ios::in | std::ios::out);
    file.seekg(middle);
    const int byte = file.get();
    file.seekp(middle);
    file.put(static_cast<char>(byte ^ 0x10));
  }
  EXPECT_EQ(origin(key(0)), Origin::built);
  EXPECT_EQ(origin(of_guide()), Origin::built);
  EXPECT_EQ(cache_->totals().damaged, 2u);
  open();
  EXPECT_EQ(origin(key(0)), Origin::disk) << "written anew";
  EXPECT_EQ(origin(of_guide()), Origin::disk);
  EXPECT_EQ(cache_->totals().damaged, 0u);
}

TEST_F(MapCacheTest, CutFilesAreBuiltAgain) {
  (void)origin(key(0));
  open();
  const fs::path file = fs::directory_iterator(folder_.path())->path();
  for (const std::uintmax_t left : {fs::file_size(file) - 1, std::uintmax_t{600}, std::uintmax_t{0}}) {
    fs::resize_file(file, left);
    EXPECT_EQ(origin(key(0)), Origin::built);
    open();
    EXPECT_EQ(origin(key(0)), Origin::disk);
    open();
  }
}

TEST_F(MapCacheTest, BothBudgetsHold) {
  const std::uint64_t one = bytes(0);
  open(3 * one, 8 * one);
  for (std::uint32_t pass = 0; pass < 20; ++pass) {
    EXPECT_EQ(origin(key(pass)), Origin::built);
    ASSERT_TRUE(cache_->flush());
    EXPECT_LE(cache_->totals().memory.bytes, 3 * one);
    EXPECT_LE(cache_->totals().disk.bytes, 8 * one);
  }
  EXPECT_EQ(origin(key(19)), Origin::memory);
  EXPECT_EQ(origin(key(16)), Origin::disk) << "evicted from memory, not from disk";
  EXPECT_EQ(origin(key(0)), Origin::built);
  EXPECT_GT(cache_->totals().memory.evictions, 0u);
  EXPECT_GT(cache_->totals().disk.evictions, 0u);
}

TEST_F(MapCacheTest, PinnedMapsStayInBothTiers) {
  const std::uint64_t one = bytes(0);
  open(4 * one, 6 * one);
  (void)origin(key(0));
  ASSERT_TRUE(cache_->pin(key(0), true).ok());
  for (std::uint32_t pass = 1; pass < 12; ++pass) (void)origin(key(pass));
  ASSERT_TRUE(cache_->flush());
  auto info = cache_->find(key(0));
  ASSERT_TRUE(info);
  EXPECT_TRUE(info->in_memory && info->on_disk && info->pinned);
  open(4 * one, 6 * one);
  EXPECT_TRUE(cache_->find(key(0))->pinned) << "after a restart";
  EXPECT_EQ(origin(key(0)), Origin::disk);
  for (std::uint32_t pass = 20; pass < 30; ++pass) (void)origin(key(pass));
  EXPECT_EQ(origin(key(0)), Origin::memory) << "pinned in memory as on disk";
  ASSERT_TRUE(cache_->pin(key(0), false).ok());
  for (std::uint32_t pass = 20; pass < 40; ++pass) (void)origin(key(pass));
  ASSERT_TRUE(cache_->flush());
  EXPECT_FALSE(cache_->find(key(0)));
}

TEST_F(MapCacheTest, NotEverythingCanBePinned) {
  const std::uint64_t one = bytes(0);
  open(5 * one, 20 * one);
  for (std::uint32_t pass = 0; pass < 4; ++pass) (void)origin(key(pass));
  EXPECT_TRUE(cache_->pin(key(0), true).ok());
  EXPECT_TRUE(cache_->pin(key(1), true).ok());
  EXPECT_TRUE(cache_->pin(key(1), true).ok());
  EXPECT_EQ(cache_->pin(key(2), true).error().code, ErrorCode::conflict);
  EXPECT_EQ(cache_->pin(key(9), true).error().code, ErrorCode::not_found);
  EXPECT_TRUE(cache_->pin(key(2), false).ok());
}

TEST_F(MapCacheTest, FindsInEitherTierWhatItLists) {
  EXPECT_FALSE(cache_->find(key(0)));
  origin(key(0));
  ASSERT_TRUE(cache_->flush());
  const auto both = cache_->find(key(0));
  ASSERT_TRUE(both && both->in_memory && both->on_disk);
  open(0);
  const auto filed = cache_->find(key(0));
  ASSERT_TRUE(filed && !filed->in_memory && filed->on_disk);
  EXPECT_EQ(filed->facts.global, both->facts.global);
  EXPECT_EQ(cache_->find(key(0))->hits, cache_->list().front().hits) << "to look is no use";
  EXPECT_FALSE(cache_->find(key(1)));
}

TEST_F(MapCacheTest, ErasesFromBothTiers) {
  (void)origin(key(0));
  EXPECT_TRUE(cache_->erase(key(0))) << "perhaps while it is being written";
  ASSERT_TRUE(cache_->flush());
  EXPECT_FALSE(cache_->erase(key(0)));
  EXPECT_TRUE(fs::is_empty(folder_.path()));
  (void)origin(key(0));
  ASSERT_TRUE(cache_->flush());
  open();
  EXPECT_TRUE(cache_->erase(key(0))) << "on disk only";
  EXPECT_EQ(origin(key(0)), Origin::built);
}

TEST_F(MapCacheTest, FreesDiskForOthers) {
  for (std::uint32_t pass = 0; pass < 4; ++pass) (void)origin(key(pass));
  ASSERT_TRUE(cache_->flush());
  const std::uint64_t all = cache_->totals().disk.bytes;
  EXPECT_EQ(cache_->free_disk(UINT64_MAX), all);
  EXPECT_EQ(cache_->totals().disk.bytes, 0u);
  EXPECT_EQ(origin(key(0)), Origin::memory) << "what is in memory stays there";
}

TEST_F(MapCacheTest, AFailureToWriteIsCountedAndHarmless) {
  ASSERT_TRUE(cache_->flush());
  fs::remove_all(folder_.path());
  EXPECT_EQ(origin(key(0)), Origin::built);
  ASSERT_TRUE(cache_->flush());
  EXPECT_EQ(cache_->totals().write_failures, 1u);
  EXPECT_EQ(origin(key(0)), Origin::memory);
  fs::create_directories(folder_.path());
}

TEST_F(MapCacheTest, ManyAtOnceBuildOnce) {
  std::vector<std::thread> threads;
  std::atomic<int> built{0}, found{0};
  for (int i = 0; i < 32; ++i) {
    threads.emplace_back([&] {
      const auto answer = cache_->get(*scene_, key(0, 50'000), Execution{}, true);
      ASSERT_TRUE(answer.ok());
      ++(answer->origin == Origin::built ? built : found);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(built, 1);
  EXPECT_EQ(found, 31);
}

TEST_F(MapCacheTest, AnotherTakesOverFromABuilderThatIsCancelled) {
  std::stop_source stop;
  const MapKey slow = key(0, 3'000'000);
  std::thread builder([&] {
    const auto answer = cache_->get(*scene_, slow, Execution{nullptr, stop.get_token()}, true);
    EXPECT_EQ(answer.error().code, ErrorCode::cancelled);
  });
  while (cache_->totals().misses == 0) std::this_thread::yield();
  std::vector<std::thread> waiters;
  std::atomic<int> built{0};
  for (int i = 0; i < 3; ++i) {
    waiters.emplace_back([&] {
      const auto answer = cache_->get(*scene_, slow, test::workers().execution(), true);
      ASSERT_TRUE(answer.ok());
      built += answer->origin == Origin::built;
    });
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  stop.request_stop();
  builder.join();
  for (std::thread& waiter : waiters) waiter.join();
  EXPECT_EQ(built, 1);
}

TEST_F(MapCacheTest, WorksWithoutADisk) {
  cache_ = std::make_unique<MapCache>(1 << 30, nullptr);
  EXPECT_EQ(origin(key(0)), Origin::built);
  EXPECT_EQ(origin(key(0)), Origin::memory);
  EXPECT_TRUE(cache_->pin(key(0), true).ok());
  EXPECT_EQ(cache_->free_disk(1), 0u);
  EXPECT_TRUE(cache_->erase(key(0)));
}

TEST_F(MapCacheTest, AJobCountsWhatItAskedFor) {
  MapUse first(*cache_);
  ASSERT_TRUE(first.guide(*scene_, of_guide(), Execution{}).ok());
  ASSERT_TRUE(first.maps(*scene_, key(0), Execution{}).ok());
  ASSERT_TRUE(first.maps(*scene_, key(0), Execution{}).ok()) << "a preview and the first pass: one request";
  EXPECT_EQ(first.misses(), 2u);
  EXPECT_EQ(first.hits(), 0u);
  open();
  MapUse second(*cache_);
  ASSERT_TRUE(second.guide(*scene_, of_guide(), Execution{}).ok());
  ASSERT_TRUE(second.maps(*scene_, key(0), Execution{}).ok());
  ASSERT_TRUE(second.maps(*scene_, key(1), Execution{}).ok());
  EXPECT_EQ(second.hits(), 2u);
  EXPECT_EQ(second.disk_hits(), 2u);
  EXPECT_EQ(second.misses(), 1u);
}

}  // namespace
}  // namespace photond
