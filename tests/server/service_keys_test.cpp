#include <filesystem>
#include <fstream>

#include "server/api/authorize.h"
#include "server/store/keys.h"
#include "tests/server/service_fixture.h"
#include "tests/support/temporary_folder.h"

namespace photond::test {
namespace {

using nlohmann::json;

class ServiceKeysTest : public ServiceTest {
 protected:
  void SetUp() override {
    options_.data_dir = folder_.path().string();
    start(options_);
  }

  KeyFile file() { return KeyFile(folder_.path()); }

  /// Makes a key while the service runs.
  NewKey make(Scope scope, const KeyLimits& limits = {}) {
    const Result<NewKey> key = make_key(scope, limits, "");
    EXPECT_TRUE(key.ok() && file().add(key->record).ok());
    return *key;
  }

  static Fields with(const NewKey& key) { return {{"Authorization", "Bearer " + key.secret}}; }

  Reply post_job(const std::string& scene, const std::string& fields, const NewKey& key) {
    return request(port_, "POST", "/v1/jobs",
                   "{\"scene\":\"" + scene + R"(","film":{"width":16,"height":12},)" + fields + "}", "application/json",
                   with(key));
  }

  TemporaryFolder folder_;
  ServiceOptions options_;
};

TEST_F(ServiceKeysTest, WithoutKeysEverythingIsOpen) {
  EXPECT_EQ(get(port_, "/v1/jobs").status, 200);
  EXPECT_EQ(get(port_, "/v1/jobs", {{"Authorization", "Bearer x"}}).status, 200);
}

TEST_F(ServiceKeysTest, OnceThereAreKeysTheyAreNeeded) {
  const NewKey reader = make(Scope::read);
  for (const char* target : {"/v1/jobs", "/v1/info", "/v1/scenes", "/metrics", "/v1/events", "/v1/maps"}) {
    const Reply none = get(port_, target);
    EXPECT_EQ(none.status, 401) << target;
    EXPECT_EQ(none.headers.at("www-authenticate"), "Bearer realm=\"photond\"");
    EXPECT_EQ(json::parse(none.body)["code"], "unauthorized");
  }
  EXPECT_EQ(get(port_, "/v1/jobs", with(reader)).status, 200);
  EXPECT_EQ(get(port_, "/v1/jobs", {{"Authorization", "bearer " + reader.secret}}).status, 200) << "any case";
  for (const char* target : {"/healthz", "/readyz", "/v1/openapi.json"}) EXPECT_EQ(get(port_, target).status, 200);
  const std::string wrong[] = {"Bearer ", "Bearer x", reader.secret, "Basic " + reader.secret, "Bearer " + reader.record.id,
                               "Bearer " + to_hex(reader.record.hash), "Bearer " + reader.secret + "0"};
  for (const std::string& field : wrong) {
    const Reply refused = get(port_, "/v1/jobs", {{"Authorization", field}});
    EXPECT_EQ(refused.status, 401) << field;
    EXPECT_EQ(refused.body.find(reader.secret), std::string::npos) << "secrets are not echoed";
  }
}

TEST_F(ServiceKeysTest, ARevokedKeyIsRefusedAtOnceAndNothingOpensAgain) {
  const NewKey key = make(Scope::admin);
  EXPECT_EQ(get(port_, "/v1/jobs", with(key)).status, 200);
  ASSERT_TRUE(file().revoke(key.record.id).ok());
  const Reply refused = get(port_, "/v1/jobs", with(key));
  EXPECT_EQ(refused.status, 401);
  EXPECT_NE(refused.headers.at("www-authenticate").find("invalid_token"), std::string::npos);
  std::filesystem::remove(file().path());
  EXPECT_EQ(get(port_, "/v1/jobs").status, 401);
  std::ofstream(file().path()) << "damaged";
  EXPECT_EQ(get(port_, "/v1/jobs", with(key)).status, 503);
}

TEST_F(ServiceKeysTest, ScopesLimitWhatAKeyMayDo) {
  const NewKey reader = make(Scope::read);
  const NewKey submitter = make(Scope::submit);
  const NewKey admin = make(Scope::admin);
  const auto upload_by = [&](const NewKey& key) {
    return request(port_, "POST", "/v1/scenes", small_glb(), "model/gltf-binary", with(key));
  };
  const Reply refused = upload_by(reader);
  EXPECT_EQ(refused.status, 403);
  EXPECT_NE(refused.headers.at("www-authenticate").find("insufficient_scope\", scope=\"submit\""), std::string::npos);
  const std::string scene = json::parse(upload_by(submitter).body)["id"];
  EXPECT_EQ(post_job(scene, R"("stop":{"passes":1})", reader).status, 403);
  const Reply job = post_job(scene, R"("method":"path","stop":{"passes":1})", submitter);
  ASSERT_EQ(job.status, 202);
  EXPECT_EQ(get(port_, "/v1/jobs/" + json::parse(job.body)["id"].get<std::string>(), with(reader)).status, 200)
      << "all keys see all jobs";
  EXPECT_EQ(request(port_, "DELETE", "/v1/maps/none", "", "", with(submitter)).status, 403);
  EXPECT_EQ(request(port_, "DELETE", "/v1/maps/none", "", "", with(admin)).status, 404);
}

TEST_F(ServiceKeysTest, AnUploadWithoutAKeyIsRefusedBeforeItIsRead) {
  make(Scope::submit);
  const std::string big(1 << 20, 'x');
  EXPECT_EQ(request(port_, "POST", "/v1/scenes", big, "model/gltf-binary").status, 401);
}

TEST_F(ServiceKeysTest, StreamsAreLimitedByKey) {
  const NewKey few = make(Scope::read, {.jobs = {}, .bytes = {}, .streams = 2});
  const NewKey other = make(Scope::read);
  const std::string head = "GET /v1/events HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer " + few.secret + "\r\n\r\n";
  Connection first(port_);
  Connection second(port_);
  first.send(head);
  second.send(head);
  first.read_until("retry:", std::chrono::seconds(5));
  second.read_until("retry:", std::chrono::seconds(5));
  const Reply third = get(port_, "/v1/events", with(few));
  EXPECT_EQ(third.status, 429);
  EXPECT_EQ(third.headers.count("retry-after"), 1u);
  EXPECT_EQ(get(port_, "/v1/jobs", with(few)).status, 200) << "short requests do not count";
  Connection others(port_);
  others.send("GET /v1/events HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer " + other.secret + "\r\n\r\n");
  EXPECT_NE(others.read_until("retry:", std::chrono::seconds(5)).find("200"), std::string::npos);
}

TEST(OpenStreams, APlaceComesBackWithTheLastCopy) {
  OpenStreams streams;
  const Caller few{.key = "k-1", .scope = Scope::read, .limits = {.jobs = {}, .bytes = {}, .streams = 1}};
  std::shared_ptr<void> first = streams.take(few);
  ASSERT_TRUE(first);
  const std::shared_ptr<void> copy = first;
  first.reset();
  EXPECT_FALSE(streams.take(few));
  EXPECT_TRUE(streams.take({.key = "k-2", .scope = Scope::read, .limits = few.limits})) << "by key";
  EXPECT_TRUE(streams.take(Caller{})) << "no key, no limit";
}

TEST(OpenStreams, OutlivesTheService) {
  auto streams = std::make_unique<OpenStreams>();
  const std::shared_ptr<void> place = streams->take(Caller{});
  streams.reset();
}

TEST(ServiceExposure, APublicAddressNeedsKeys) {
  TemporaryFolder folder;
  ServiceOptions options;
  options.port = 0;
  options.host = "0.0.0.0";
  options.data_dir = folder.path().string();
  const auto refused = Service::start(options);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("--insecure"), std::string::npos);
  ASSERT_TRUE(KeyFile(folder.path()).add(make_key(Scope::read, {}, "")->record).ok());
  EXPECT_TRUE(Service::start(options).ok());
  TemporaryFolder empty;
  options.data_dir = empty.path().string();
  options.insecure = true;
  EXPECT_TRUE(Service::start(options).ok());
}

}  // namespace
}  // namespace photond::test
