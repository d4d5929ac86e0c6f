#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "core/base/digest.h"
#include "tests/server/service_fixture.h"

namespace photond::test {
namespace {

using nlohmann::json;

TEST_F(ServiceTest, AnUploadIsReportedAndNamedByItsContent) {
  const std::string glb = small_glb();
  const Reply first = request(port_, "POST", "/v1/scenes", glb, "model/gltf-binary");
  ASSERT_EQ(first.status, 201) << first.body;
  const json scene = json::parse(first.body);
  EXPECT_EQ(scene["id"], to_hex(sha256(std::as_bytes(std::span(glb.data(), glb.size())))));
  EXPECT_EQ(first.headers.at("location"), "/v1/scenes/" + scene["id"].get<std::string>());
  EXPECT_EQ(scene["report"]["counts"]["triangles"], 4);
  EXPECT_EQ(scene["report"]["counts"]["emissive_triangles"], 2);
  EXPECT_EQ(scene["report"]["cameras"].size(), 2u);
  EXPECT_EQ(scene["report"]["materials"][1]["name"], "lamp");
  EXPECT_FALSE(scene["plan"]["items"].empty());
  EXPECT_EQ(request(port_, "POST", "/v1/scenes", glb, "model/gltf-binary").status, 200);

  const std::string self = scene["urls"]["self"];
  EXPECT_EQ(json::parse(get(port_, self).body), scene);
  const Reply file = get(port_, scene["urls"]["glb"]);
  EXPECT_EQ(file.body, glb);
  EXPECT_EQ(file.headers.at("content-type"), "model/gltf-binary");
  EXPECT_EQ(get(port_, scene["urls"]["glb"], {{"If-None-Match", file.headers.at("etag")}}).status, 304);
  const json list = json::parse(get(port_, "/v1/scenes").body)["scenes"];
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0]["id"], scene["id"]);
  EXPECT_EQ(list[0]["sample"], false);

  EXPECT_EQ(request(port_, "DELETE", self).status, 204);
  EXPECT_EQ(get(port_, self).status, 404);
  EXPECT_EQ(request(port_, "DELETE", self).status, 404);
}

TEST_F(ServiceTest, ASceneKeepsTheFirstNameItGets) {
  const std::string glb = small_glb();
  const auto upload = [&](const std::string& query) {
    const Reply reply = request(port_, "POST", "/v1/scenes" + query, glb, "model/gltf-binary");
    EXPECT_LT(reply.status, 300) << reply.body;
    return json::parse(reply.body);
  };
  EXPECT_EQ(upload("")["name"], "");
  const json named = upload("?name=K%C3%BCche%20%231.glb");
  EXPECT_EQ(named["name"], "Küche #1.glb");
  EXPECT_EQ(upload("?name=other.glb")["name"], "Küche #1.glb");
  restart();
  EXPECT_EQ(json::parse(get(port_, "/v1/scenes").body)["scenes"][0]["name"], "Küche #1.glb");
  EXPECT_EQ(json::parse(get(port_, named["urls"]["self"]).body)["name"], "Küche #1.glb");
  EXPECT_EQ(request(port_, "POST", "/v1/scenes?name=" + std::string(201, 'x'), glb, "model/gltf-binary").status, 400);
}

TEST_F(ServiceTest, AGlbIsOneWhateverItIsSentAs) {
  const std::string glb = small_glb();
  const json scene = json::parse(request(port_, "POST", "/v1/scenes", glb, "model/gltf+json").body);
  EXPECT_EQ(scene["media_type"], "model/gltf-binary");
  ASSERT_TRUE(scene["urls"]["glb"].is_string()) << scene["urls"];
  EXPECT_EQ(get(port_, scene["urls"]["glb"]).body, glb);
}

std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    std::uint32_t bits = 0;
    for (std::size_t i = at; i < at + 3; ++i) bits = bits << 8 | (i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0);
    for (std::size_t i = 0; i < 4; ++i) text += at + i > bytes.size() ? '=' : kDigits[bits >> (18 - 6 * i) & 63];
  }
  return text;
}

TEST_F(ServiceTest, JsonIsNoGlbWhateverItIsSentAs) {
  std::string gltf = small_gltf();
  gltf.replace(gltf.find("quad.bin"), 8, "data:application/octet-stream;base64," + base64(quad_bin()));
  const Reply reply = request(port_, "POST", "/v1/scenes", gltf, "model/gltf-binary");
  ASSERT_EQ(reply.status, 201) << reply.body;
  const json scene = json::parse(reply.body);
  EXPECT_EQ(scene["media_type"], "model/gltf+json");
  EXPECT_TRUE(scene["urls"]["glb"].is_null()) << scene["urls"];
}

TEST_F(ServiceTest, ABrokenSceneIsAProblemThatNamesThePlace) {
  std::string glb = small_glb();
  glb.replace(glb.find("\"count\":4"), 9, "\"count\":9");
  const Reply reply = request(port_, "POST", "/v1/scenes", glb, "model/gltf-binary");
  EXPECT_EQ(reply.status, 422);
  EXPECT_EQ(reply.headers.at("content-type"), "application/problem+json");
  const json problem = json::parse(reply.body);
  EXPECT_EQ(problem["status"], 422);
  EXPECT_NE(problem["pointer"].get<std::string>().find("accessors"), std::string::npos) << reply.body;
  EXPECT_EQ(json::parse(get(port_, "/v1/scenes").body)["scenes"].size(), 0u);
}

TEST_F(ServiceTest, AJsonSceneMayNotReadFiles) {
  const Reply reply = request(port_, "POST", "/v1/scenes", small_gltf(), "model/gltf+json");
  EXPECT_EQ(reply.status, 422) << reply.body;
}

TEST_F(ServiceTest, SamplesAreListedFromTheStartAndStay) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("photond_samples_" + std::to_string(getpid()));
  fs::create_directories(folder);
  std::ofstream(folder / "lamp.glb", std::ios::binary) << small_glb();
  std::ofstream(folder / "notes.txt") << "no scene";
  ServiceOptions options;
  options.samples_dir = folder.string();
  start(options);
  fs::remove_all(folder);
  const json list = json::parse(get(port_, "/v1/scenes").body)["scenes"];
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0]["name"], "lamp");
  EXPECT_EQ(list[0]["sample"], true);
  const std::string self = list[0]["urls"]["self"];
  EXPECT_EQ(json::parse(get(port_, self).body)["report"]["counts"]["triangles"], 4);
  EXPECT_EQ(request(port_, "DELETE", self).status, 409);
}

TEST_F(ServiceTest, ASceneInUseCannotBeDeleted) {
  const std::string scene = upload();
  const std::string id = submit(scene, R"("stop":{"seconds":60})");
  const Reply refused = request(port_, "DELETE", "/v1/scenes/" + scene);
  EXPECT_EQ(refused.status, 409);
  EXPECT_EQ(json::parse(refused.body)["code"], "conflict");
  EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/cancel").status, 202);
  wait_for_end(id);
  EXPECT_EQ(request(port_, "DELETE", "/v1/scenes/" + scene).status, 204);
}

TEST_F(ServiceTest, ScenesSurviveARestartAndADamagedOneCanBeUploadedAgain) {
  const std::string scene = upload();
  restart();
  EXPECT_EQ(get(port_, "/v1/scenes/" + scene + ".glb").body, small_glb());
  EXPECT_EQ(json::parse(get(port_, "/v1/scenes/" + scene).body)["report"]["counts"]["triangles"], 4);
  restart();
  std::ofstream(data_->path() / "data" / "scenes" / scene, std::ios::binary) << "rubbish";
  const Reply damaged = get(port_, "/v1/scenes/" + scene + ".glb");
  EXPECT_EQ(damaged.status, 404);
  EXPECT_NE(damaged.body.find("upload it again"), std::string::npos) << damaged.body;
  EXPECT_EQ(request(port_, "POST", "/v1/scenes", small_glb(), "model/gltf-binary").status, 201);
  EXPECT_EQ(get(port_, "/v1/scenes/" + scene + ".glb").body, small_glb());
}

TEST_F(ServiceTest, PagesOfScenesSkipNoneThoughSamplesAreDatedAnew) {
  const TemporaryFolder samples;
  ServiceOptions options;
  options.samples_dir = samples.path().string();
  std::ofstream(samples.path() / "b.glb", std::ios::binary) << small_glb("b");
  start(options);
  std::ofstream(samples.path() / "a.glb", std::ios::binary) << small_glb("a");
  restart(options);  // a has come after b, but is dated before it
  upload();
  std::vector<std::string> names;
  std::string next;
  do {
    const json page = json::parse(get(port_, "/v1/scenes?limit=1" + next).body);
    for (const json& scene : page["scenes"]) names.push_back(scene["name"]);
    next = page["next_cursor"].is_null() ? "" : "&cursor=" + page["next_cursor"].get<std::string>();
  } while (!next.empty());
  EXPECT_EQ(names, (std::vector<std::string>{"b", "a", ""}));
}

TEST_F(ServiceTest, ASlowReaderOfASceneFileCostsLittleMemory) {
  constexpr std::int64_t kFileBytes = 40 << 20, kReaders = 8;
  const TemporaryFolder samples;
  std::ofstream(samples.path() / "large.glb", std::ios::binary) << std::string(kFileBytes, 'x');
  ServiceOptions options;
  options.samples_dir = samples.path().string();
  start(options);
  const std::string target = json::parse(get(port_, "/v1/scenes").body)["scenes"][0]["urls"]["glb"];
  EXPECT_LT(memory_of_slow_readers(target, kReaders), kReaders * kFileBytes / 4);
}

TEST_F(ServiceTest, ASampleThatIsNoLongerShippedBecomesAnOrdinaryScene) {
  const TemporaryFolder samples;
  std::ofstream(samples.path() / "lamp.glb", std::ios::binary) << small_glb();
  ServiceOptions options;
  options.samples_dir = samples.path().string();
  start(options);
  EXPECT_EQ(json::parse(get(port_, "/v1/scenes").body)["scenes"][0]["sample"], true);
  restart(options);
  EXPECT_EQ(json::parse(get(port_, "/v1/scenes").body)["scenes"][0]["sample"], true);
  restart();
  const json list = json::parse(get(port_, "/v1/scenes").body)["scenes"];
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0]["sample"], false);
  EXPECT_EQ(request(port_, "DELETE", list[0]["urls"]["self"].get<std::string>()).status, 204);
}

}  // namespace
}  // namespace photond::test
