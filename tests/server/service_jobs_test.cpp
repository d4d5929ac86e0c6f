#include <thread>

#include "core/film/encode.h"
#include "tests/server/service_fixture.h"

namespace photond::test {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

TEST_F(ServiceTest, AJobRunsToAPicture) {
  const std::string id = submit(upload(), R"("method":"path","stop":{"passes":5},"label":"first")");
  const json done = wait_for_end(id);
  EXPECT_EQ(done["state"], "succeeded") << done;
  EXPECT_EQ(done["passes"], 5);
  EXPECT_EQ(done["label"], "first");
  EXPECT_EQ(done["plan"]["method"], "path");
  EXPECT_GT(done["seconds"].get<double>(), 0);
  EXPECT_GT(done["first_frame_seconds"].get<double>(), 0);
  EXPECT_GT(done["error"]["relative"].get<double>(), 0);
  EXPECT_EQ(done["error"]["noise"], done["error"]["relative"]) << "path tracing has no bias";
  EXPECT_EQ(done["error"]["bias"], 0);
  EXPECT_EQ(done["rejected_samples"], 0);
  EXPECT_GE(done["revision"].get<int>(), 2);
  EXPECT_TRUE(done["problem"].is_null());

  const std::string frame = done["urls"]["frame"];
  const Reply exr = get(port_, frame + ".exr");
  ASSERT_EQ(exr.status, 200);
  const auto image = decode_exr(bytes_of(exr.body));
  ASSERT_TRUE(image.ok());
  EXPECT_NE(exr.body.find("error.bound.R"), std::string::npos) << "the result carries its error";
  EXPECT_EQ(image->width, 16);
  EXPECT_EQ(image->height, 12);
  float brightest = 0;
  for (const Rgb& pixel : image->pixels) brightest = std::max(brightest, pixel.x);
  EXPECT_GT(brightest, 0.01f) << "the picture is black";
  EXPECT_EQ(get(port_, frame + ".png").body.substr(1, 3), "PNG");
  EXPECT_EQ(get(port_, frame + ".jpg").body.substr(0, 2), "\xff\xd8");
  EXPECT_EQ(get(port_, frame + ".gif").status, 404);

  const json series = json::parse(get(port_, done["urls"]["series"]).body)["points"];
  EXPECT_EQ(series.size(), done["revision"].get<std::size_t>());
  EXPECT_EQ(series.back()["passes"], 5);
  EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/cancel").status, 409);
  EXPECT_EQ(request(port_, "DELETE", "/v1/jobs/" + id).status, 204);
  EXPECT_EQ(get(port_, "/v1/jobs/" + id).status, 404);
  EXPECT_EQ(get(port_, frame + ".png").status, 404);
}

TEST_F(ServiceTest, ADeletedSceneIsNoneForJobs) {
  const std::string scene = upload();
  const std::string job = R"({"scene":")" + scene + R"(","stop":{"passes":1}})";
  ASSERT_EQ(post_json(port_, "/v1/jobs?dry_run=true", job).status, 200);
  ASSERT_EQ(request(port_, "DELETE", "/v1/scenes/" + scene).status, 204);
  for (const char* target : {"/v1/jobs", "/v1/jobs?dry_run=true"}) {
    const Reply refusal = post_json(port_, target, job);
    EXPECT_EQ(refusal.status, 422) << refusal.body;
    EXPECT_NE(refusal.body.find("/scene"), std::string::npos) << refusal.body;
  }
}

TEST_F(ServiceTest, ABiasedMethodIsLabelledInTheJobAndInItsPictures) {
  const std::string scene = upload();
  for (const std::string method : {"photon_map", "progressive"}) {
    const bool biased = method == "photon_map";
    const json done = wait_for_end(submit(scene, R"("photons_per_pass":3000,"stop":{"passes":2},"method":")" + method + "\""));
    EXPECT_EQ(done["plan"]["biased"], biased);
    for (const char* extension : {".exr", ".png", ".jpg"}) {
      const Reply frame = get(port_, done["urls"]["frame"].get<std::string>() + extension);
      ASSERT_EQ(frame.status, 200);
      EXPECT_EQ(frame.body.find("photond photon_map: biased") != std::string::npos, biased) << extension;
    }
  }
}

TEST_F(ServiceTest, PicturesAreNamedByRevision) {
  const std::string id = submit(upload(), R"("method":"path","stop":{"passes":3})");
  const json done = wait_for_end(id);
  const std::string latest = "/v1/jobs/" + id + "/frames/latest.png";
  const Reply newest = get(port_, latest);
  ASSERT_EQ(newest.status, 200);
  EXPECT_EQ(newest.headers.at("content-location"), done["urls"]["frame"].get<std::string>() + ".png");
  EXPECT_EQ(get(port_, newest.headers.at("content-location")).body, newest.body);
  EXPECT_EQ(get(port_, latest, {{"If-None-Match", newest.headers.at("etag")}}).status, 304);
  const std::string after = std::to_string(done["revision"].get<int>());
  EXPECT_EQ(get(port_, latest + "?after=0").status, 200);
  EXPECT_EQ(get(port_, latest + "?after=" + after).status, 204);
  const Clock::time_point begin = Clock::now();
  EXPECT_EQ(get(port_, latest + "?after=" + after + "&wait=20").status, 204) << "an ended job has no news";
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(5));
  EXPECT_EQ(get(port_, "/v1/jobs/" + id + "/frames/999.png").status, 404);
  EXPECT_EQ(get(port_, "/v1/jobs/" + id + "/frames/0.png").status, 404);
  EXPECT_EQ(get(port_, latest + "?after=x").status, 400);
}

TEST_F(ServiceTest, ALongPollWaitsForTheNextVersion) {
  const std::string id = submit(upload(), R"("method":"path","stop":{"seconds":30})");
  Reply reply = get(port_, "/v1/jobs/" + id);
  for (int i = 0; i < 3; ++i) {
    const std::string etag = reply.headers.at("etag");
    reply = get(port_, "/v1/jobs/" + id + "?wait=20", {{"If-None-Match", etag}});
    ASSERT_EQ(reply.status, 200);
    EXPECT_NE(reply.headers.at("etag"), etag);
  }
  const Reply first = get(port_, "/v1/jobs/" + id + "/frames/latest.jpg?after=0&wait=20");
  ASSERT_EQ(first.status, 200);
  const Reply next =
      get(port_, "/v1/jobs/" + id + "/frames/latest.jpg?wait=20&after=" + first.headers.at("photond-revision"));
  ASSERT_EQ(next.status, 200);
  EXPECT_NE(next.headers.at("etag"), first.headers.at("etag"));
  EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/cancel").status, 202);
  wait_for_end(id);
  reply = get(port_, "/v1/jobs/" + id);
  const Clock::time_point begin = Clock::now();
  EXPECT_EQ(get(port_, "/v1/jobs/" + id + "?wait=1", {{"If-None-Match", reply.headers.at("etag")}}).status,
            304);
  EXPECT_GE(Clock::now() - begin, std::chrono::milliseconds(900));
}

TEST_F(ServiceTest, CancelStopsWithinASecondEvenInsideALongPass) {
  const std::string fields = R"("method":"path","film":{"width":2500,"height":2500},"stop":{"seconds":600})";
  const std::string id = submit(upload(), fields);
  while (job(id)["state"] != "rendering") std::this_thread::sleep_for(std::chrono::milliseconds(20));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const std::string queued = submit(upload(), fields);
  const Clock::time_point begin = Clock::now();
  ASSERT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/cancel").status, 202);
  EXPECT_EQ(wait_for_end(id)["state"], "canceled");
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(1));
  const Reply again = request(port_, "POST", "/v1/jobs/" + queued + "/cancel");
  EXPECT_EQ(again.status, 202);
  EXPECT_EQ(wait_for_end(queued)["state"], "canceled");
  EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/cancel").status, 202) << "asking again is no error";
  EXPECT_EQ(request(port_, "POST", "/v1/jobs/j-none/cancel").status, 404);
}

TEST_F(ServiceTest, ASecondJobFindsTheMapsOfTheFirst) {
  const std::string scene = upload();
  const std::string common = R"("method":"progressive","photons_per_pass":2000,"stop":{"passes":4})";
  const json cold = wait_for_end(submit(scene, common));
  ASSERT_EQ(cold["state"], "succeeded") << cold;
  EXPECT_EQ(cold["maps"]["hits"], 0);
  EXPECT_EQ(cold["maps"]["misses"], 5) << "four passes and the guide";
  const json warm =
      wait_for_end(submit(scene, common + R"(,"camera":"above","radius":0.2,"film":{"width":20,"height":10})"));
  EXPECT_EQ(warm["maps"]["hits"], 5) << warm;
  EXPECT_EQ(warm["maps"]["disk_hits"], 0);
  EXPECT_EQ(warm["maps"]["misses"], 0);
  // The same content in another file: cameras and names are not part of it.
  EXPECT_EQ(wait_for_end(submit(upload(small_glb("renamed")), common))["maps"]["hits"], 5);
  EXPECT_EQ(wait_for_end(submit(scene, common + R"(,"seed":1)"))["maps"]["hits"], 0);

  const json maps = json::parse(get(port_, "/v1/maps").body);
  ASSERT_EQ(maps["maps"].size(), 10u);
  EXPECT_EQ(maps["hits"]["memory"], 10);
  EXPECT_EQ(maps["maps"][0]["hits"], 2);
  const std::string key = maps["maps"][0]["key"];
  EXPECT_EQ(request(port_, "DELETE", "/v1/maps/" + key).status, 204);
  EXPECT_EQ(request(port_, "DELETE", "/v1/maps/" + key).status, 404);
  EXPECT_EQ(wait_for_end(submit(scene, common))["maps"]["hits"], 4);
  const std::string metrics = get(port_, "/metrics").body;
  EXPECT_NE(metrics.find("photond_map_cache_hits_total{tier=\"memory\"} 14\n"), std::string::npos) << metrics;
  EXPECT_NE(metrics.find("photond_jobs{state=\"succeeded\"} 5\n"), std::string::npos);
  EXPECT_NE(metrics.find("photond_passes_total 20\n"), std::string::npos);
}

TEST_F(ServiceTest, AJobKeepsOnlyItsFirstMapsInASmallCache) {
  const std::string common = R"("method":"progressive","photons_per_pass":2000,"stop":{"passes":)";
  wait_for_end(submit(upload(), common + "1}"));
  const json one = json::parse(get(port_, "/v1/maps").body);
  ASSERT_EQ(one["maps"].size(), 2u) << "the maps of the pass and the guide";
  EXPECT_EQ(one["maps"][0]["kind"], "photons");
  EXPECT_EQ(one["maps"][1]["kind"], "guide");
  ServiceOptions options;
  options.map_cache_bytes = 16 * one["maps"][0]["bytes"].get<std::uint64_t>();
  start(options);
  const json done = wait_for_end(submit(upload(), common + "40}"));
  ASSERT_EQ(done["state"], "succeeded");
  const json maps = json::parse(get(port_, "/v1/maps").body);
  EXPECT_EQ(maps["evictions"]["memory"], 0);
  EXPECT_GE(maps["maps"].size(), 4u) << "a quarter of the budget";
  EXPECT_LE(maps["maps"].size(), 7u);
  for (std::size_t i = 0; i + 1 < maps["maps"].size(); ++i) EXPECT_EQ(maps["maps"][i]["pass"], i);
  EXPECT_EQ(maps["maps"].back()["kind"], "guide");
}

TEST_F(ServiceTest, JobsOfAClassShareTheCores) {
  const std::string scene = upload();
  const std::string common = R"("method":"path","film":{"width":256,"height":256},"stop":{"passes":100})";
  const Clock::time_point begin = Clock::now();
  const std::string a = submit(scene, common);
  const std::string b = submit(scene, common);
  wait_for_end(a);
  const auto until_a = Clock::now() - begin;
  wait_for_end(b);
  const auto until_b = Clock::now() - begin;
  EXPECT_LT(until_b, until_a + until_a / 2)
      << "turn by turn they end together; one after the other it is twice";
}

TEST_F(ServiceTest, MistakesAreNamedByPointer) {
  const std::string scene = upload();
  const auto problem_of = [&](const std::string& fields) {
    const Reply reply = post_json(port_, "/v1/jobs", "{\"scene\":\"" + scene + "\"," + fields + "}");
    EXPECT_EQ(reply.status, 422) << fields << reply.body;
    EXPECT_EQ(reply.headers.at("content-type"), "application/problem+json");
    return json::parse(reply.body).value("pointer", "");
  };
  EXPECT_EQ(problem_of(R"("film":{"width":0})"), "/film/width");
  EXPECT_EQ(problem_of(R"("film":{"width":16384,"height":16384})"), "/film");
  EXPECT_EQ(problem_of(R"("camera":"nobody")"), "/camera");
  EXPECT_EQ(problem_of(R"("camera":7)"), "/camera");
  EXPECT_EQ(problem_of(R"("wrong":1)"), "/wrong");
  const std::string unknown(64, '0');
  const Reply none = post_json(port_, "/v1/jobs", "{\"scene\":\"" + unknown + "\"}");
  EXPECT_EQ(none.status, 422);
  EXPECT_EQ(json::parse(none.body)["pointer"], "/scene");
  EXPECT_EQ(post_json(port_, "/v1/jobs", "{").status, 400);
  EXPECT_EQ(post_json(port_, "/v1/jobs", std::string(60'000, '[')).status, 400);
  EXPECT_EQ(post_json(port_, "/v1/jobs", std::string(70'000, ' ')).status, 413);
  EXPECT_EQ(request(port_, "POST", "/v1/jobs", "{}", "text/plain").status, 415);
  EXPECT_EQ(json::parse(get(port_, "/v1/jobs").body)["jobs"].size(), 0u);
}

TEST_F(ServiceTest, ADryRunOnlyPlans) {
  const Reply reply =
      post_json(port_, "/v1/jobs?dry_run=true", "{\"scene\":\"" + upload() + R"(","method":"progressive"})");
  ASSERT_EQ(reply.status, 200) << reply.body;
  EXPECT_EQ(json::parse(reply.body)["plan"]["method"], "progressive");
  EXPECT_EQ(json::parse(get(port_, "/v1/jobs").body)["jobs"].size(), 0u);
}

TEST_F(ServiceTest, TheListOfJobsIsFilteredAndPaged) {
  const std::string scene = upload();
  std::vector<std::string> ids;
  for (int i = 0; i < 5; ++i) {
    ids.push_back(submit(scene, R"("method":"path","stop":{"passes":1},"label":")" +
                                    std::string(i % 2 ? "odd" : "even") + "\""));
  }
  for (const std::string& id : ids) wait_for_end(id);
  const json page = json::parse(get(port_, "/v1/jobs?limit=3").body);
  ASSERT_EQ(page["jobs"].size(), 3u);
  EXPECT_EQ(page["jobs"][0]["id"], ids[4]);
  submit(scene, R"("method":"path","stop":{"passes":1})");  // inserts do not shift the next page
  const json rest =
      json::parse(get(port_, "/v1/jobs?limit=3&cursor=" + page["next_cursor"].get<std::string>()).body);
  ASSERT_EQ(rest["jobs"].size(), 2u);
  EXPECT_EQ(rest["jobs"][0]["id"], ids[1]);
  EXPECT_TRUE(rest["next_cursor"].is_null());
  EXPECT_EQ(json::parse(get(port_, "/v1/jobs?label=odd").body)["jobs"].size(), 2u);
  EXPECT_EQ(json::parse(get(port_, "/v1/jobs?state=failed").body)["jobs"].size(), 0u);
  EXPECT_EQ(get(port_, "/v1/jobs?state=nonsense").status, 400);
  EXPECT_EQ(get(port_, "/v1/jobs?limit=0").status, 400);
}

TEST_F(ServiceTest, AJobThatWouldTakeTooMuchMemoryIsRefused) {
  ServiceOptions options;
  options.max_job_memory_bytes = 64 << 20;
  start(options);
  EXPECT_EQ(json::parse(get(port_, "/v1/info").body)["limits"]["max_job_memory_bytes"], 64 << 20);
  const std::string scene = upload();
  const auto pointer = [&](const std::string& target, const std::string& fields) {
    const Reply reply = post_json(port_, target, "{\"scene\":\"" + scene + "\"," + fields + "}");
    EXPECT_EQ(reply.status, 422) << reply.body;
    return json::parse(reply.body).value("pointer", "");
  };
  const std::string large = R"("method":"path","film":{"width":1024,"height":1024})";
  const std::string many = R"("method":"progressive","photons_per_pass":100000000)";
  for (const std::string target : {"/v1/jobs", "/v1/jobs?dry_run=true"}) {
    EXPECT_EQ(pointer(target, large), "/film");
    EXPECT_EQ(pointer(target, many), "/photons_per_pass");
  }
  EXPECT_EQ(pointer("/v1/jobs", R"("method":"progressive","film":{"width":320,"height":320})"), "/film")
      << "with the bands of what is gathered";
  EXPECT_EQ(pointer("/v1/maps", many), "/photons_per_pass");
  const std::string fits = R"("method":"path","film":{"width":320,"height":320},"stop":{"passes":1})";
  EXPECT_EQ(wait_for_end(submit(scene, fits))["state"], "succeeded");
}

TEST_F(ServiceTest, TooManyJobsAreRefusedAndOldOnesForgotten) {
  ServiceOptions options;
  options.max_live_jobs = 2;
  options.max_kept_jobs = 2;
  start(options);
  const std::string scene = upload();
  const std::string a = submit(scene, R"("method":"path","stop":{"seconds":60})");
  const std::string b = submit(scene, R"("method":"path","stop":{"seconds":60})");
  const Reply refused = post_json(port_, "/v1/jobs", "{\"scene\":\"" + scene + "\"}");
  EXPECT_EQ(refused.status, 429);
  EXPECT_EQ(refused.headers.count("retry-after"), 1u);
  for (const std::string& id : {a, b}) {
    EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/cancel").status, 202);
    wait_for_end(id);
  }
  for (int i = 0; i < 2; ++i) wait_for_end(submit(scene, R"("method":"path","stop":{"passes":1})"));
  EXPECT_EQ(get(port_, "/v1/jobs/" + a).status, 404);
  EXPECT_EQ(get(port_, "/v1/jobs/" + b).status, 200);
}

}  // namespace
}  // namespace photond::test
