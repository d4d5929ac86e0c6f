#include "server/jobs/checkpoint.h"

#include <gtest/gtest.h>

#include <filesystem>

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

}  // namespace
}  // namespace photond::test
