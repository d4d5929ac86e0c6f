#include "server/store/blobs.h"

#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "tests/support/temporary_folder.h"

namespace photond {
namespace {

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

class BlobsTest : public ::testing::Test {
 protected:
  void SetUp() override { open(); }
  void open() {
    auto blobs = Blobs::open(folder());
    ASSERT_TRUE(blobs.ok()) << blobs.error().message;
    blobs_ = std::move(*blobs);
  }
  std::filesystem::path folder() const { return temporary_.path() / "blobs"; }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder()), {}));
  }

  const test::TemporaryFolder temporary_;
  std::unique_ptr<Blobs> blobs_;
};

TEST_F(BlobsTest, AreNamedByTheirContent) {
  const auto name = blobs_->put(bytes_of("abc"));
  ASSERT_TRUE(name.ok());
  EXPECT_EQ(to_hex(*name), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(*blobs_->put(bytes_of("abc")), *name);
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(blobs_->total_bytes(), 3u);
  EXPECT_EQ(**blobs_->get(*name), bytes_of("abc"));
  const auto empty = blobs_->put(std::span<const std::byte>());
  EXPECT_TRUE((*blobs_->get(*empty))->empty());
}

TEST_F(BlobsTest, CanBeWrittenInPieces) {
  const auto name = blobs_->put([](const Blobs::Sink& sink) {
    for (const char* piece : {"a", "b", "", "c"}) {
      if (const Status written = sink(bytes_of(piece)); !written) return written;
    }
    return Status(Done{});
  });
  ASSERT_TRUE(name.ok());
  EXPECT_EQ(**blobs_->get(*name), bytes_of("abc"));
}

TEST_F(BlobsTest, AContentThatFailsLeavesNothing) {
  const auto name = blobs_->put([](const Blobs::Sink& sink) -> Status {
    EXPECT_TRUE(sink(bytes_of("abc")).ok());
    return cancelled();
  });
  ASSERT_FALSE(name.ok());
  EXPECT_EQ(name.error().code, ErrorCode::cancelled);
  EXPECT_EQ(files(), 0u);
}

TEST_F(BlobsTest, SurviveReopeningAndUnfinishedOnesDoNot) {
  const auto name = blobs_->put(bytes_of("abc"));
  std::ofstream(folder() / "17.new") << "half";
  open();
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(blobs_->total_bytes(), 3u);
  EXPECT_TRUE(blobs_->get(*name).ok());
}

TEST_F(BlobsTest, ADamagedOneIsNotServedButDroppedAndCanBePutAgain) {
  for (const char* damage : {"abd", "ab", "abcd", ""}) {
    const auto name = blobs_->put(bytes_of("abc"));
    std::ofstream(blobs_->path_of(*name), std::ios::trunc) << damage;
    const auto read = blobs_->get(*name);
    ASSERT_FALSE(read.ok()) << damage;
    EXPECT_EQ(read.error().code, ErrorCode::not_found);
    EXPECT_EQ(files(), 0u);
  }
  EXPECT_EQ(blobs_->get(*blobs_->put(bytes_of("x"))).ok(), true);
}

TEST_F(BlobsTest, AreReadAsFilesOnceTheyWereChecked) {
  const std::string text(3'000'000, 'x');
  const auto name = blobs_->put(bytes_of(text + "end"));
  std::string end(3, ' ');
  const auto read_end = [&] {
    const auto file = blobs_->open_file(*name);
    ASSERT_TRUE(file.ok()) << file.error().message;
    EXPECT_EQ(file->length, text.size() + 3);
    EXPECT_TRUE(blobs_->remove(*name).ok());
    const auto into = std::as_writable_bytes(std::span(end));
    EXPECT_TRUE(file->file->read_at(into, text.size()).ok()) << "though its name is gone";
    EXPECT_EQ(end, "end");
    EXPECT_FALSE(file->file->read_at(std::as_writable_bytes(std::span(end)), text.size() + 1).ok());
    EXPECT_EQ(blobs_->open_file(*name).error().code, ErrorCode::not_found);
  };
  read_end();
  ASSERT_TRUE(blobs_->put(bytes_of(text + "end")).ok());
  open();
  read_end();
  ASSERT_TRUE(blobs_->put(bytes_of(text + "end")).ok());
  open();
  std::fstream(blobs_->path_of(*name), std::ios::in | std::ios::out) << "y";
  EXPECT_EQ(blobs_->open_file(*name).error().code, ErrorCode::not_found) << "of an earlier life, and damaged";
  EXPECT_EQ(files(), 0u);
}

TEST_F(BlobsTest, PuttingOverADamagedOneMendsIt) {
  const auto name = blobs_->put(bytes_of("abc"));
  std::ofstream(blobs_->path_of(*name), std::ios::trunc) << "?";
  ASSERT_TRUE(blobs_->put(bytes_of("abc")).ok());
  EXPECT_EQ(**blobs_->get(*name), bytes_of("abc"));
}

TEST_F(BlobsTest, AreRemovedByNameAndSwept) {
  const auto a = blobs_->put(bytes_of("a")), b = blobs_->put(bytes_of("bb")), c = blobs_->put(bytes_of("ccc"));
  EXPECT_TRUE(blobs_->remove(*a).ok());
  EXPECT_TRUE(blobs_->remove(*a).ok()) << "twice is no error";
  EXPECT_EQ(blobs_->get(*a).error().code, ErrorCode::not_found);
  const auto swept = blobs_->sweep([&](const Digest& name) { return name == *c; });
  EXPECT_EQ(*swept, 1u);
  EXPECT_FALSE(blobs_->get(*b).ok());
  EXPECT_TRUE(blobs_->get(*c).ok());
  EXPECT_EQ(blobs_->total_bytes(), 3u);
}

TEST_F(BlobsTest, ThreadsMayPutTheSame) {
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) threads.emplace_back([&] { EXPECT_TRUE(blobs_->put(bytes_of("same")).ok()); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(blobs_->total_bytes(), 4u);
}

TEST_F(BlobsTest, AFolderThatCannotBeIsAnError) {
  std::ofstream(temporary_.path() / "file") << "x";
  EXPECT_FALSE(Blobs::open(temporary_.path() / "file").ok());
  EXPECT_FALSE(Blobs::open(temporary_.path() / "file" / "below").ok());
}

TEST(BlobsOnAFullDisk, SayThatTheDiskIsFull) {
  const Error error = system_error("cannot write", ENOSPC);
  EXPECT_TRUE(is_disk_full(error));
  EXPECT_FALSE(is_disk_full(system_error("cannot write", EIO)));
  Result<File> full = File::open("/dev/full", 1 /* O_WRONLY */);
  ASSERT_TRUE(full.ok());
  const Status written = full->write(bytes_of("abc"));
  ASSERT_FALSE(written.ok());
  EXPECT_TRUE(is_disk_full(written.error()));
}

}  // namespace
}  // namespace photond
