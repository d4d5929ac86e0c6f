#include "server/store/map_files.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstring>
#include <fstream>
#include <thread>

#include "server/store/map_key_text.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

namespace photond {
namespace {

namespace fs = std::filesystem;

// Maps of a dark scene with a lot of nothing would do, but what is in files must be theirs: small ones of a room.
class MapFilesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    scene_ = test::busy_room();
    open(1 << 30);
    ASSERT_TRUE(put(0).ok());
    size_ = files_->find(key(0))->bytes;
  }

  void open(std::uint64_t budget) {
    files_.reset();
    auto opened = MapFiles::open(folder_.path() / "maps", budget);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    files_ = std::move(*opened);
  }
  MapKey key(std::uint32_t pass) const { return {scene_->digest, {500, 0}, pass}; }
  Status put(std::uint32_t pass) {
    const auto maps = *build_photon_maps(*scene_, key(pass), Execution{});
    SectionList list = map_sections(*maps, 0.5);
    return files_->put(key(pass), {maps->global.size(), maps->caustic.size(), 0.5},
                       list.pieces(map_identity(key(pass)), Execution{}));
  }
  bool reads(std::uint32_t pass) {
    const auto file = files_->map(key(pass));
    return file && read_photon_maps(*file, key(pass), Execution{}) != nullptr;
  }
  std::size_t files_in_folder() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_.path() / "maps"), {}));
  }
  fs::path path(std::uint32_t pass, const char* extension = ".map") const {
    return folder_.path() / "maps" / (key_text(key(pass)) + extension);
  }

  test::TemporaryFolder folder_;
  std::shared_ptr<const PreparedScene> scene_;
  std::unique_ptr<MapFiles> files_;
  std::uint64_t size_ = 0;
};

TEST_F(MapFilesTest, FindsFilesAgain) {
  ASSERT_TRUE(put(1).ok());
  open(1 << 30);
  const auto infos = files_->list();
  ASSERT_EQ(infos.size(), 2u);
  EXPECT_EQ(infos[1].key, key(1));
  EXPECT_EQ(infos[1].facts.build_seconds, 0.5);
  EXPECT_GT(infos[1].facts.global, 0u);
  EXPECT_EQ(infos[1].bytes, fs::file_size(path(1)));
  EXPECT_TRUE(reads(0) && reads(1));
  EXPECT_EQ(files_->totals().bytes, infos[0].bytes + infos[1].bytes);
}

TEST_F(MapFilesTest, HoldsTheBudgetByTheLeastRecentUse) {
  open(4 * size_ - size_ / 2);   // room for three
  ASSERT_TRUE(put(1).ok() && put(2).ok());
  EXPECT_TRUE(reads(0));   // used later than 1
  ASSERT_TRUE(put(3).ok());
  EXPECT_FALSE(files_->find(key(1)));
  EXPECT_TRUE(reads(0) && reads(2) && reads(3));
  EXPECT_EQ(files_in_folder(), 3u);
  EXPECT_LE(files_->totals().bytes, files_->budget_bytes());
  EXPECT_EQ(files_->totals().evictions, 1u);
  // A smaller budget is held from the start on; the order of use has survived.
  open(2 * size_ - size_ / 2);
  EXPECT_EQ(files_in_folder(), 1u);
  EXPECT_TRUE(reads(3));
}

TEST_F(MapFilesTest, PinnedFilesStay) {
  ASSERT_TRUE(put(1).ok());
  EXPECT_TRUE(files_->pin(key(0), true));
  EXPECT_TRUE(files_->pin(key(0), true));
  EXPECT_FALSE(files_->pin(key(7), true));
  open(2 * size_ - size_ / 2);
  EXPECT_EQ(files_->list().size(), 1u);
  EXPECT_TRUE(files_->find(key(0))->pinned) << "after a restart, too";
  ASSERT_TRUE(put(2).ok());
  EXPECT_FALSE(files_->find(key(2))) << "there is no room beside what is pinned";
  EXPECT_EQ(files_->evictable_bytes(), 0u);
  EXPECT_EQ(files_->evict(UINT64_MAX), 0u);
  EXPECT_TRUE(reads(0));
  EXPECT_TRUE(files_->pin(key(0), false));
  ASSERT_TRUE(put(2).ok());
  EXPECT_FALSE(files_->find(key(0)));
  EXPECT_TRUE(reads(2));
}

TEST_F(MapFilesTest, GivesWayToWhatCannotBeMadeAgain) {
  ASSERT_TRUE(put(1).ok() && put(2).ok());
  const std::uint64_t before = files_->totals().bytes;
  EXPECT_EQ(files_->evictable_bytes(), before);
  const std::uint64_t freed = files_->evict(size_ + 1);
  EXPECT_GE(freed, size_ + 1);
  EXPECT_EQ(files_->totals().bytes, before - freed);
  EXPECT_FALSE(files_->find(key(0))) << "the oldest first";
  EXPECT_TRUE(reads(2));
  EXPECT_EQ(files_in_folder(), 1u);
}

TEST_F(MapFilesTest, WhatIsMappedOutlivesItsFile) {
  const auto file = files_->map(key(0));
  EXPECT_TRUE(files_->erase(key(0)));
  EXPECT_FALSE(files_->erase(key(0)));
  EXPECT_FALSE(fs::exists(path(0)));
  EXPECT_NE(read_photon_maps(*file, key(0), Execution{}), nullptr);
}

TEST_F(MapFilesTest, DropsWhatIsNotWholeOrNotItsOwn) {
  std::ofstream(folder_.path() / "maps" / "3.new") << "half of a";
  std::ofstream(path(5)) << "no map";
  fs::copy_file(path(0), path(6));   // under another's name
  ASSERT_TRUE(put(1).ok());
  // Of another photon stage: the identity is another.
  std::fstream other(path(1), std::ios::binary | std::ios::in | std::ios::out);
  other.seekp(8);
  other.put('?');
  other.close();
  open(1 << 30);
  EXPECT_EQ(files_->list().size(), 1u);
  EXPECT_EQ(files_in_folder(), 1u);
  EXPECT_TRUE(reads(0));
}

TEST_F(MapFilesTest, AFileThatVanishesIsForgotten) {
  fs::remove(path(0));
  EXPECT_FALSE(files_->map(key(0)));
  EXPECT_EQ(files_->totals().entries, 0u);
  EXPECT_EQ(files_->totals().bytes, 0u);
}

TEST_F(MapFilesTest, SaysWhereAFolderCannotBeMade) {
  std::ofstream(folder_.path() / "file") << "";
  EXPECT_FALSE(MapFiles::open(folder_.path() / "file" / "maps", 1).ok());
}

TEST_F(MapFilesTest, ServesManyThreads) {
  std::vector<std::thread> threads;
  for (std::uint32_t t = 0; t < 8; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 20; ++i) {
        EXPECT_TRUE(put(t % 4).ok());
        (void)reads(t % 4);
        if (i % 5 == 4) files_->erase(key(t % 4));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  std::uint64_t bytes = 0;
  for (const auto& info : files_->list()) bytes += fs::file_size(path(info.key.pass));
  EXPECT_EQ(files_->totals().bytes, bytes);
  EXPECT_EQ(files_in_folder(), files_->list().size());
}

TEST(MapKeyText, IsReadBackExactly) {
  MapKey key{{}, {262'144, UINT64_MAX}, UINT32_MAX};
  key.scene.bytes[3] = 0xab;
  EXPECT_EQ(parse_key(key_text(key)), key);
  key.set = PhotonSet::caustic;
  EXPECT_EQ(parse_key(key_text(key)), key);
  const std::string text = key_text(MapKey{});
  ASSERT_TRUE(parse_key(text));
  for (const std::string& wrong : {std::string(), text + "-", text + "0-", text.substr(1), "x" + text.substr(1),
                                   text.substr(0, text.size() - 1), text.substr(0, text.size() - 2) + "-01",
                                   text.substr(0, text.size() - 1) + "4294967296", text + " ", "-" + text}) {
    EXPECT_FALSE(parse_key(wrong)) << wrong;
  }
}

}  // namespace
}  // namespace photond
