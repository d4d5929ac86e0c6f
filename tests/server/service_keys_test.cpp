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

TEST_F(ServiceKeysTest, StreamsEndWithTheirKey) {
  const std::string id = submit(upload(), R"("method":"path","stop":{"seconds":600})");
  Connection before(port_);  // opened while nobody needed a key
  before.send("GET /v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  before.read_until("retry", std::chrono::seconds(5));
  const NewKey key = make(Scope::read), other = make(Scope::read);
  before.read_all(std::chrono::seconds(3));
  EXPECT_TRUE(before.closed());
  const auto ask = [&](Connection& connection, const std::string& target, const NewKey& by) {
    connection.send("GET " + target + " HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer " + by.secret +
                    "\r\n\r\n");
  };
  Connection events(port_), pictures(port_), poll(port_), stays(port_);
  ask(events, "/v1/events", key);
  ask(pictures, "/v1/jobs/" + id + "/stream.mjpg", key);
  ask(poll, "/v1/jobs/" + id + "/frames/latest.png?wait=20&after=1000000", key);
  ask(stays, "/v1/events", other);
  events.read_until("retry", std::chrono::seconds(5));
  pictures.read_until("image/jpeg", std::chrono::seconds(5));
  stays.read_until("retry", std::chrono::seconds(5));
  ASSERT_TRUE(file().revoke(key.record.id).ok());
  for (Connection* connection : {&events, &pictures, &poll}) {
    connection->read_all(std::chrono::seconds(3));
    EXPECT_TRUE(connection->closed());
  }
  EXPECT_EQ(parse_reply(poll.read_all()).status, 401);
  EXPECT_FALSE(stays.closed());
  EXPECT_EQ(request(port_, "GET", "/v1/jobs", "", "", with(other)).status, 200);
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
  EXPECT_EQ(request(port_, "POST", "/v1/maps/none/pin", "", "", with(submitter)).status, 403);
  EXPECT_EQ(request(port_, "POST", "/v1/maps/none/pin", "", "", with(admin)).status, 404);
}

TEST_F(ServiceKeysTest, MapsAreEverybodysButPrewarmingIsItsKeys) {
  const std::string scene = upload();
  const NewKey one = make(Scope::submit);
  const NewKey other = make(Scope::submit);
  const NewKey admin = make(Scope::admin);
  const auto prewarm = [&](const std::string& fields) {
    const Reply reply = request(port_, "POST", "/v1/maps", "{\"scene\":\"" + scene + "\"," + fields + "}",
                                "application/json", with(one));
    return json::parse(reply.body);
  };
  const auto remove = [&](const std::string& key, const NewKey& by) {
    return request(port_, "DELETE", "/v1/maps/" + key, "", "", with(by)).status;
  };
  const std::string small = R"("photons_per_pass":2000)";
  json built = prewarm(small);
  for (int i = 0; i < 600 && built["ready"] != 2; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    built = prewarm(small);
  }
  const std::string ready = built["keys"].back();
  const std::string waiting = prewarm(R"("photons_per_pass":1000000,"passes":64)")["keys"].back();
  EXPECT_EQ(remove(ready, one), 403);
  EXPECT_EQ(remove(waiting, other), 404) << "for another key there is no such map";
  EXPECT_EQ(remove(waiting, one), 204);
  EXPECT_EQ(remove(waiting, one), 404);
  EXPECT_EQ(remove(ready, admin), 204);
}

TEST_F(ServiceKeysTest, ASubmitKeyChangesOnlyWhatCameWithIt) {
  const std::string before = upload();
  const std::string open = submit(before, R"("method":"path","stop":{"seconds":600})");
  const NewKey one = make(Scope::submit);
  const NewKey other = make(Scope::submit);
  const NewKey admin = make(Scope::admin);
  const Reply made = post_job(before, R"("method":"path","stop":{"seconds":600})", one);
  ASSERT_EQ(made.status, 202) << made.body;
  const std::string job = "/v1/jobs/" + json::parse(made.body)["id"].get<std::string>();
  const auto post = [&](const std::string& target, const NewKey& key, const std::string& body = "") {
    return request(port_, "POST", target, body, body.empty() ? "" : "application/json", with(key));
  };
  for (const char* what : {"/cancel", "/pause", "/resume", "/retry"}) {
    const Reply refused = post(job + what, other);
    EXPECT_EQ(refused.status, 403) << what;
    EXPECT_EQ(json::parse(refused.body)["code"], "not_yours");
  }
  EXPECT_EQ(post(job + "/extend", other, R"({"stop":{"passes":9}})").status, 403);
  EXPECT_EQ(request(port_, "DELETE", job, "", "", with(other)).status, 403);
  EXPECT_EQ(post("/v1/jobs/" + open + "/cancel", one).status, 403) << "what came without a key is nobody's";
  EXPECT_EQ(post("/v1/jobs/j-0/cancel", other).status, 404);
  EXPECT_EQ(post(job + "/pause", one).status, 202);
  restart(options_);
  EXPECT_EQ(post(job + "/resume", other).status, 403) << "owners outlive a restart";
  EXPECT_EQ(post(job + "/resume", one).status, 202);
  EXPECT_EQ(post(job + "/cancel", admin).status, 202);
  EXPECT_EQ(post("/v1/jobs/" + open + "/cancel", admin).status, 202);
  const auto ended = [&] { return json::parse(get(port_, job, with(one)).body)["state"] == "canceled"; };
  for (int i = 0; i < 500 && !ended(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(request(port_, "DELETE", job, "", "", with(one)).status, 204);
}

TEST_F(ServiceKeysTest, ASceneIsItsFirstUploaders) {
  const std::string glb = small_glb();
  const NewKey one = make(Scope::submit, {.jobs = {}, .bytes = glb.size(), .streams = {}});
  const NewKey other = make(Scope::submit, {.jobs = {}, .bytes = glb.size() - 1, .streams = {}});
  const auto upload_by = [&](const NewKey& key) {
    return request(port_, "POST", "/v1/scenes", glb, "model/gltf-binary", with(key));
  };
  EXPECT_EQ(upload_by(other).status, 507) << "it may not have as much";
  const Reply first = upload_by(one);
  ASSERT_EQ(first.status, 201) << first.body;
  EXPECT_EQ(upload_by(other).status, 200) << "what is known takes no room";
  restart(options_);
  const std::string scene = "/v1/scenes/" + json::parse(first.body)["id"].get<std::string>();
  EXPECT_EQ(request(port_, "DELETE", scene, "", "", with(other)).status, 403);
  EXPECT_EQ(request(port_, "DELETE", scene, "", "", with(one)).status, 204);
  EXPECT_EQ(upload_by(one).status, 201) << "and its room is free again";
}

TEST_F(ServiceKeysTest, OnlyWhoseItIsNamesWhatCameWithoutAName) {
  const NewKey one = make(Scope::submit), other = make(Scope::submit), admin = make(Scope::admin);
  const std::string sky = std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n") + "\x80\x80\x80\x81\x80\x80\x80\x81";
  const auto name_after = [&](const std::string& file, const std::string& query, const NewKey& key) {
    const bool scene = file != sky;
    return json::parse(request(port_, "POST", (scene ? "/v1/scenes" : "/v1/environments") + query, file,
                               scene ? "model/gltf-binary" : "image/vnd.radiance", with(key)).body)["name"];
  };
  for (const std::string& file : {small_glb(), sky}) {
    EXPECT_EQ(name_after(file, "", one), "");
    EXPECT_EQ(name_after(file, "?name=rude", other), "");
    EXPECT_EQ(name_after(file, "?name=lamp", one), "lamp");
  }
  EXPECT_EQ(name_after(small_glb("second"), "", one), "");
  EXPECT_EQ(name_after(small_glb("second"), "?name=lamp", admin), "lamp");
}

TEST_F(ServiceKeysTest, JobsAreLimitedByKey) {
  const std::string scene = upload();
  const NewKey few = make(Scope::submit, {.jobs = 2, .bytes = {}, .streams = {}});
  const NewKey other = make(Scope::submit);
  const std::string endless = R"("method":"path","stop":{"seconds":600})";
  const Reply first = post_job(scene, endless, few);
  ASSERT_EQ(first.status, 202);
  ASSERT_EQ(post_job(scene, endless, few).status, 202);
  const Reply refused = post_job(scene, endless, few);
  EXPECT_EQ(refused.status, 429) << refused.body;
  EXPECT_TRUE(refused.headers.contains("retry-after"));
  EXPECT_EQ(post_job(scene, endless, other).status, 202);
  const std::string job = "/v1/jobs/" + json::parse(first.body)["id"].get<std::string>();
  EXPECT_EQ(request(port_, "POST", job + "/cancel", "", "", with(few)).status, 202);
  const auto ended = [&] { return json::parse(get(port_, job, with(few)).body)["state"] == "canceled"; };
  for (int i = 0; i < 500 && !ended(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(post_job(scene, endless, few).status, 202) << "an ended one makes room";
}

TEST_F(ServiceKeysTest, EnvironmentsNeedMoreThanAKeyToRead) {
  const NewKey reader = make(Scope::read);
  const NewKey submitter = make(Scope::submit);
  const std::string none = "/v1/environments/" + std::string(64, '0');
  EXPECT_EQ(request(port_, "POST", "/v1/environments", "x", "image/x-exr", with(reader)).status, 403);
  EXPECT_EQ(request(port_, "POST", "/v1/environments", "x", "image/x-exr", with(submitter)).status, 422);
  EXPECT_EQ(request(port_, "DELETE", none, "", "", with(reader)).status, 403);
  EXPECT_EQ(request(port_, "DELETE", none, "", "", with(submitter)).status, 404);
}

TEST_F(ServiceKeysTest, AnEnvironmentIsItsFirstUploaders) {
  const std::string sky = std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n") + "\x80\x80\x80\x81\x80\x80\x80\x81";
  const std::string glb = small_glb();
  const NewKey one = make(Scope::submit, {.jobs = {}, .bytes = sky.size() + glb.size() - 1, .streams = {}});
  const NewKey other = make(Scope::submit, {.jobs = {}, .bytes = sky.size() - 1, .streams = {}});
  const auto upload_by = [&](const NewKey& key) {
    return request(port_, "POST", "/v1/environments", sky, "image/vnd.radiance", with(key));
  };
  EXPECT_EQ(upload_by(other).status, 507) << "it may not have as much";
  EXPECT_TRUE(json::parse(get(port_, "/v1/environments", with(one)).body)["environments"].empty());
  const Reply first = upload_by(one);
  ASSERT_EQ(first.status, 201) << first.body;
  EXPECT_EQ(upload_by(other).status, 200) << "what is known takes no room";
  EXPECT_EQ(request(port_, "POST", "/v1/scenes", glb, "model/gltf-binary", with(one)).status, 507)
      << "scenes and environments count together";
  restart(options_);
  const std::string environment = "/v1/environments/" + json::parse(first.body)["id"].get<std::string>();
  EXPECT_EQ(request(port_, "DELETE", environment, "", "", with(other)).status, 403);
  EXPECT_EQ(request(port_, "DELETE", environment, "", "", with(one)).status, 204);
  EXPECT_EQ(request(port_, "POST", "/v1/scenes", glb, "model/gltf-binary", with(one)).status, 201);
}

TEST_F(ServiceKeysTest, IdempotencyKeysAreNamesOfTheApiKey) {
  const std::string scene = upload();
  const auto post = [&](const NewKey& key) {
    Fields fields = with(key);
    fields.emplace_back("Idempotency-Key", "a");
    const std::string body = "{\"scene\":\"" + scene + R"(","film":{"width":16,"height":12},"stop":{"passes":1}})";
    return request(port_, "POST", "/v1/jobs", body, "application/json", fields).headers["location"];
  };
  const NewKey one = make(Scope::submit), other = make(Scope::submit);
  const std::string first = post(one);
  EXPECT_EQ(post(one), first);
  EXPECT_NE(post(other), first);
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
