#include <future>
#include <set>

#include "tests/server/service_fixture.h"

namespace photond::test {
namespace {

using nlohmann::json;

class IdempotencyTest : public ServiceTest {
 protected:
  void SetUp() override {
    ServiceTest::SetUp();
    scene_ = upload();
  }

  std::string body(const std::string& fields = R"("method":"path","stop":{"passes":1})") {
    return "{\"scene\":\"" + scene_ + R"(","film":{"width":16,"height":12},)" + fields + "}";
  }
  Reply post(const std::string& key, const std::string& body, const std::string& query = "") {
    return request(port_, "POST", "/v1/jobs" + query, body, "application/json", {{"Idempotency-Key", key}});
  }
  std::size_t jobs() { return json::parse(get(port_, "/v1/jobs").body)["jobs"].size(); }
  static void expect_replay(const Reply& reply, const Reply& first) {
    EXPECT_EQ(reply.status, 202) << reply.body;
    EXPECT_EQ(reply.body, first.body);
    for (const char* name : {"location", "etag", "content-type", "cache-control"})
      EXPECT_EQ(reply.headers.at(name), first.headers.at(name)) << name;
    EXPECT_EQ(reply.headers.at("idempotency-replayed"), "true");
  }

  std::string scene_;
};

TEST_F(IdempotencyTest, TheSameRequestIsAnsweredAgainAlsoAfterARestart) {
  const Reply first = post("a", body());
  ASSERT_EQ(first.status, 202) << first.body;
  EXPECT_FALSE(first.headers.contains("idempotency-replayed"));
  expect_replay(post("a", body()), first);
  const std::string id = json::parse(first.body)["id"];
  wait_for_end(id);
  expect_replay(post("a", body()), first);
  restart();
  expect_replay(post("a", body()), first);
  EXPECT_EQ(jobs(), 1u);
  EXPECT_EQ(request(port_, "DELETE", "/v1/jobs/" + id).status, 204);
  expect_replay(post("a", body()), first);
  EXPECT_EQ(jobs(), 0u) << "a repetition makes nothing, not even when the job is gone";
}

TEST_F(IdempotencyTest, AnotherBodyUnderTheSameKeyIsRefused) {
  ASSERT_EQ(post("a", body()).status, 202);
  const Reply refused = post("a", body(R"("method":"path","stop":{"passes":2})"));
  EXPECT_EQ(refused.status, 422);
  EXPECT_EQ(json::parse(refused.body)["code"], "idempotency_key_reused");
  EXPECT_EQ(post("b", body()).status, 202);
  EXPECT_EQ(post_json(port_, "/v1/jobs", body()).status, 202) << "without a key each request counts";
  EXPECT_EQ(jobs(), 3u);
}

TEST_F(IdempotencyTest, OfSixtyFourAtOnceOneMakesAJob) {
  std::vector<std::future<Reply>> posts;
  for (int i = 0; i < 64; ++i) posts.push_back(std::async(std::launch::async, [&] { return post("a", body()); }));
  std::set<std::string> locations;
  int made = 0;
  for (auto& one : posts) {
    const Reply reply = one.get();
    ASSERT_TRUE(reply.status == 202 || reply.status == 409 || reply.status == 503) << reply.status << reply.body;
    if (reply.status == 202) {
      locations.insert(reply.headers.at("location"));
      made += reply.headers.contains("idempotency-replayed") ? 0 : 1;
    } else {
      EXPECT_TRUE(reply.headers.contains("retry-after"));
    }
  }
  EXPECT_EQ(locations.size(), 1u);
  EXPECT_EQ(made, 1);
  EXPECT_EQ(jobs(), 1u);
}

TEST_F(IdempotencyTest, RefusalsAndDryRunsTakeNoKey) {
  const std::string unknown(64, '0');
  EXPECT_EQ(post("a", "{\"scene\":\"" + unknown + "\"}").status, 422);
  EXPECT_EQ(post("a", body(), "?dry_run=true").status, 200);
  EXPECT_EQ(post("a", body()).status, 202);
  EXPECT_EQ(post("a", body(R"("seed":1)"), "?dry_run=true").status, 200);
  EXPECT_EQ(jobs(), 1u);
}

TEST_F(IdempotencyTest, AKeyIsOneTo255VisibleCharacters) {
  EXPECT_EQ(post(std::string(255, '~'), body()).status, 202);
  EXPECT_EQ(post("123", body()).status, 202) << "a number is text, too";
  for (const std::string& key : {std::string(), std::string(256, 'a'), std::string("a b"), std::string("\xc3\xa4")}) {
    const Reply refused = post(key, body());
    EXPECT_EQ(refused.status, 400) << key;
    EXPECT_EQ(json::parse(refused.body)["code"], "invalid_parameter") << key;
  }
  EXPECT_EQ(jobs(), 2u);
}

}  // namespace
}  // namespace photond::test
