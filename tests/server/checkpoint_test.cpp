#include "server/jobs/checkpoint.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/server/temporary_store.h"

namespace photond::test {
namespace {

TEST(Checkpoint, IsNotWrittenForAJobThatIsCanceled) {
  TemporaryStore stored;
  std::stop_source stop;
  stop.request_stop();
  const Status saved = save_checkpoint(*stored.files, "j-1", "identity", Film(8, 8), 1, stop.get_token());
  ASSERT_FALSE(saved.ok());
  EXPECT_EQ(saved.error().code, ErrorCode::cancelled);
  EXPECT_TRUE(stored.files->checkpoints("j-1")->empty());
  EXPECT_EQ(stored.files->checkpoint_files().total_bytes(), 0u);
}

class CheckpointsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    JobRecord job;
    job.id = "j-1";
    Event event;
    event.job = job.id;
    ASSERT_TRUE(stored_.store->add_job(job, event).ok());
  }
  void save(const std::string& identity, std::uint32_t passes) {
    Film film(8, 8);
    for (std::uint32_t pass = 0; pass < passes; ++pass) add_pass(film, pass, {Image(8, 8)});
    ASSERT_TRUE(save_checkpoint(*stored_.files, "j-1", identity, film, 1, {}).ok());
  }
  /// How many passes there are to go on from.
  std::uint32_t restored(const std::string& identity) {
    const auto found = restore_checkpoint(*stored_.files, "j-1", identity);
    EXPECT_TRUE(found.ok());
    return *found ? (*found)->film.pass_count() : 0;
  }
  std::uint32_t newest() { return stored_.files->checkpoints("j-1")->at(0).passes; }

  TemporaryStore stored_;
};

TEST_F(CheckpointsTest, OfAnotherProgramDoNotPushOutItsOwn) {
  save("old", 20);
  save("old", 21);
  EXPECT_EQ(restored("new"), 0u);
  EXPECT_TRUE(stored_.files->checkpoints("j-1")->empty());
  save("new", 1);
  save("new", 2);
  save("new", 3);
  EXPECT_EQ(newest(), 3u);
  EXPECT_EQ(restored("new"), 3u);
}

TEST_F(CheckpointsTest, ThatAreDamagedDoNotPushOutLaterOnes) {
  save("this", 10);
  save("this", 20);
  const auto damaged = stored_.files->checkpoints("j-1")->at(0);
  std::ofstream(stored_.files->checkpoint_files().path_of(damaged.blob)) << "rubbish";
  EXPECT_EQ(restored("this"), 10u);
  EXPECT_EQ(newest(), 10u);
  save("this", 11);
  save("this", 12);
  EXPECT_EQ(restored("this"), 12u);
}

}  // namespace
}  // namespace photond::test
