#include "server/store/answers.h"

#include <gtest/gtest.h>

#include "tests/server/temporary_store.h"

namespace photond {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

class AnswersTest : public ::testing::Test {
 protected:
  Status put(const std::string& owner, const std::string& key, WallTime now) {
    return stored_.database->write([&](Transaction& transaction) {
      return Answers::put(transaction, owner, key, {sha256({}), "j-1", "\"e\"", 202, "{\"a\": \"ä\"}"}, now);
    });
  }
  bool has(const std::string& owner, const std::string& key, WallTime now) {
    const auto found = Answers(*stored_.database).find(owner, key, now);
    EXPECT_TRUE(found.ok());
    return found->has_value();
  }

  test::TemporaryStore stored_;
  const WallTime noon_{hours(500'000)};
};

TEST_F(AnswersTest, IsFoundAgainByOwnerAndKey) {
  ASSERT_TRUE(put("k-1", "a", noon_).ok());
  stored_.open();
  const auto found = Answers(*stored_.database).find("k-1", "a", noon_);
  ASSERT_TRUE(found.ok() && *found);
  EXPECT_TRUE((*found)->request == sha256({}));
  EXPECT_EQ((*found)->job, "j-1");
  EXPECT_EQ((*found)->etag, "\"e\"");
  EXPECT_EQ((*found)->status, 202);
  EXPECT_EQ((*found)->body, "{\"a\": \"ä\"}");
  EXPECT_FALSE(has("k-2", "a", noon_));
  EXPECT_FALSE(has("", "a", noon_));
  EXPECT_FALSE(has("k-1", "A", noon_));
}

TEST_F(AnswersTest, IsForgottenAfterADay) {
  ASSERT_TRUE(put("", "a", noon_).ok());
  EXPECT_TRUE(has("", "a", noon_ + Answers::kLifetime - milliseconds(1)));
  EXPECT_FALSE(has("", "a", noon_ + Answers::kLifetime));
  EXPECT_FALSE(put("", "a", noon_).ok()) << "a name is given once";
  ASSERT_TRUE(put("", "a", noon_ + Answers::kLifetime).ok()) << "and again when it is free";
  ASSERT_TRUE(put("", "b", noon_ + 2 * Answers::kLifetime).ok());
  std::uint64_t rows = 0;
  const Status counted = stored_.database->read([&](Transaction& transaction) {
    Query count = transaction.query("SELECT count(*) FROM answers");
    if (count.next()) rows = count.whole(0);
    return count.status();
  });
  ASSERT_TRUE(counted.ok());
  EXPECT_EQ(rows, 1u) << "what is too old takes no room";
}

}  // namespace
}  // namespace photond
