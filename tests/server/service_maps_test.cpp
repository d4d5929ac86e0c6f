#include <algorithm>
#include <ctime>
#include <thread>

#include "tests/server/service_fixture.h"
#include "tests/support/temporary_folder.h"

namespace photond::test {
namespace {

using nlohmann::json;

class ServiceMapsTest : public ServiceTest {
 protected:
  json maps() { return json::parse(get(port_, "/v1/maps").body); }
  json map_list() { return maps()["maps"]; }
  Reply prewarm(const std::string& scene, const std::string& fields = "") {
    return post_json(port_, "/v1/maps", "{\"scene\":\"" + scene + R"(","photons_per_pass":2000)" + fields + "}");
  }
  /// Asks until all maps are there.
  json wait_for_maps(const std::string& scene, const std::string& fields = "") {
    for (int i = 0; i < 600; ++i) {
      const Reply reply = prewarm(scene, fields);
      if (reply.status != 202) return json::parse(reply.body);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    ADD_FAILURE() << "the maps are not built";
    return {};
  }

  const std::string job_ = R"("method":"progressive","photons_per_pass":2000,"stop":{"passes":3})";
};

TEST_F(ServiceMapsTest, ARestartFindsTheMaps) {
  const json cold = wait_for_end(submit(upload(), job_));
  EXPECT_EQ(cold["maps"], (json{{"hits", 0}, {"disk_hits", 0}, {"misses", 4}}));
  restart();
  const json found = map_list();
  EXPECT_EQ(found.size(), 4u);
  for (const json& map : found) EXPECT_TRUE(map["disk"] == true && map["memory"] == false) << map;
  const json warm = wait_for_end(submit(upload(), job_ + R"(,"camera":"above")"));
  EXPECT_EQ(warm["maps"], (json{{"hits", 4}, {"disk_hits", 4}, {"misses", 0}}));
  const json list = maps();
  EXPECT_EQ(list["hits"], (json{{"memory", 0}, {"disk", 4}}));
  for (const json& map : list["maps"]) {
    EXPECT_TRUE(map["disk"] == true && map["memory"] == true) << map;
    EXPECT_EQ(map["hits"], 1);
    EXPECT_GT(map["build_seconds"], 0);
  }
  const std::string metrics = get(port_, "/metrics").body;
  EXPECT_NE(metrics.find("photond_map_cache_hits_total{tier=\"disk\"} 4\n"), std::string::npos) << metrics;
}

TEST_F(ServiceMapsTest, PicturesDoNotDependOnWhereMapsComeFrom) {
  const std::string first = submit(upload(), job_);
  wait_for_end(first);
  const Reply built = get(port_, "/v1/jobs/" + first + "/frames/latest.exr");
  restart();
  const std::string second = submit(upload(), job_);
  EXPECT_EQ(wait_for_end(second)["maps"]["misses"], 0);
  const Reply read = get(port_, "/v1/jobs/" + second + "/frames/latest.exr");
  ASSERT_EQ(read.status, 200);
  EXPECT_EQ(built.body, read.body);
}

TEST_F(ServiceMapsTest, PrewarmedMapsAreHits) {
  const std::string scene = upload();
  const Reply asked = prewarm(scene, R"(,"passes":3)");
  EXPECT_EQ(asked.status, 202) << asked.body;
  EXPECT_EQ(json::parse(asked.body)["keys"].size(), 4u);
  const json ready = wait_for_maps(scene, R"(,"passes":3)");
  EXPECT_EQ(ready["ready"], 4);
  EXPECT_EQ(wait_for_end(submit(scene, job_))["maps"]["misses"], 0);
}

TEST_F(ServiceMapsTest, PrewarmedMapsAreThoseOfTheMethod) {
  const std::string scene = upload();
  for (const std::string method : {"hybrid", "photon_map"}) {
    const std::string fields = R"("method":")" + method + '"';
    wait_for_maps(scene, R"(,"passes":2,)" + fields);
    const std::string job = fields + R"(,"photons_per_pass":2000,"stop":{"passes":2})";
    const json ended = wait_for_end(submit(scene, job));
    EXPECT_EQ(ended["state"], "succeeded");
    EXPECT_EQ(ended["maps"]["misses"], 0) << method;
  }
  EXPECT_EQ(prewarm(scene, R"(,"method":"path")").status, 422);
}

TEST_F(ServiceMapsTest, ThirtyTwoRequestsForAColdMapBuildItOnce) {
  const std::string scene = upload();
  std::vector<std::thread> clients;
  for (int i = 0; i < 32; ++i) {
    clients.emplace_back([&, i] {
      if (i % 2 == 0) {
        const Reply reply = prewarm(scene);
        EXPECT_TRUE(reply.status == 200 || reply.status == 202) << reply.body;
      } else {
        const std::string fields = R"("method":"progressive","photons_per_pass":2000,"stop":{"passes":1})";
        EXPECT_EQ(wait_for_end(submit(scene, fields))["state"], "succeeded");
      }
    });
  }
  for (std::thread& client : clients) client.join();
  wait_for_maps(scene);
  EXPECT_EQ(maps()["misses"], 2) << "the map and the guide";
}

TEST_F(ServiceMapsTest, PinsAndEvictions) {
  const json ready = wait_for_maps(upload());
  const std::string key = ready["keys"][1];
  const Reply pinned = request(port_, "POST", "/v1/maps/" + key + "/pin");
  ASSERT_EQ(pinned.status, 200) << pinned.body;
  EXPECT_EQ(json::parse(pinned.body)["pinned"], true);
  restart();
  const auto pinned_maps = [&] {
    const json list = map_list();
    return std::count_if(list.begin(), list.end(), [](const json& map) { return map["pinned"] == true; });
  };
  EXPECT_EQ(pinned_maps(), 1);
  EXPECT_EQ(request(port_, "POST", "/v1/maps/" + key + "/unpin").status, 200);
  EXPECT_EQ(pinned_maps(), 0);
  EXPECT_EQ(request(port_, "DELETE", "/v1/maps/" + key).status, 204);
  EXPECT_EQ(request(port_, "DELETE", "/v1/maps/" + key).status, 404);
  EXPECT_EQ(request(port_, "POST", "/v1/maps/" + key + "/pin").status, 404);
  EXPECT_EQ(request(port_, "POST", "/v1/maps/nonsense/pin").status, 404);
  restart();
  EXPECT_EQ(map_list().size(), 1u) << "the guide";
}

TEST_F(ServiceMapsTest, DeletingAMapThatIsYetToBeBuiltEndsThePrewarming) {
  const std::string scene = upload();
  const std::string many = R"({"scene":")" + scene + R"(","photons_per_pass":1000000,"passes":64})";
  const json asked = json::parse(post_json(port_, "/v1/maps", many).body);
  ASSERT_EQ(asked["keys"].size(), 65u);
  while (map_list().size() < 2) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  const std::string last = asked["keys"].back();
  ASSERT_EQ(request(port_, "DELETE", "/v1/maps/" + last).status, 204);
  EXPECT_EQ(request(port_, "DELETE", "/v1/maps/" + last).status, 404) << "nobody is to build it any more";
  // What computes may take a second to notice.
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const json left = maps();
  EXPECT_LT(left["maps"].size(), 64u);
  const std::clock_t before = std::clock();
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const double cpu_seconds = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
  EXPECT_LT(cpu_seconds, 0.1) << "something is left running";
  EXPECT_EQ(maps()["maps"], left["maps"]);
  EXPECT_EQ(post_json(port_, "/v1/maps", many).status, 202) << "asking again begins again";
  EXPECT_EQ(request(port_, "DELETE", "/v1/maps/" + last).status, 204);
}

TEST_F(ServiceMapsTest, PrewarmingMistakesAreNamed) {
  const std::string scene = upload();
  EXPECT_EQ(post_json(port_, "/v1/maps", "{}").status, 422);
  EXPECT_EQ(prewarm(scene, R"(,"passes":0)").status, 422);
  EXPECT_EQ(prewarm(scene, R"(,"passes":65)").status, 422);
  EXPECT_EQ(prewarm(scene, R"(,"camera":0)").status, 422);
  const Reply unknown = prewarm(std::string(64, '0'));
  EXPECT_EQ(unknown.status, 422);
  EXPECT_EQ(json::parse(unknown.body)["pointer"], "/scene");
}

TEST_F(ServiceMapsTest, ALargeFilmIsPreviewedBeforeItsFirstPass) {
  const std::string id = submit(upload(), R"("method":"progressive","photons_per_pass":2000,
      "film":{"width":160,"height":120},"stop":{"passes":1})");
  const json done = wait_for_end(id);
  EXPECT_EQ(done["revision"], 2);
  EXPECT_EQ(done["maps"], (json{{"hits", 0}, {"disk_hits", 0}, {"misses", 2}})) << "one map for both";
  EXPECT_EQ(get(port_, "/v1/jobs/" + id + "/frames/2.png").status, 200);
  EXPECT_EQ(get(port_, "/v1/jobs/" + id + "/frames/1.png").status, 404) << "an ended job keeps its newest picture";
  const json series = json::parse(get(port_, "/v1/jobs/" + id + "/series").body);
  ASSERT_EQ(series["points"].size(), 1u) << "a preview is no point of the curve";
  EXPECT_EQ(series["points"][0]["revision"], 2);
}

// The irradiance that rays read belongs to no camera.
TEST_F(ServiceMapsTest, ASecondCameraReadsTheSameIrradiance) {
  const std::string scene = upload();
  const std::string fields = R"("method":"photon_map","photons_per_pass":3000,"stop":{"passes":2},"camera":)";
  const json one = wait_for_end(submit(scene, fields + R"({"eye":[0,0.5,3],"target":[0,0,0],"up":[0,1,0],"yfov_deg":50})"));
  EXPECT_EQ(one["maps"]["hits"], 0) << one;
  const json other = wait_for_end(submit(scene, fields + R"({"eye":[1,1,3],"target":[0,0,0],"up":[0,1,0],"yfov_deg":50})"));
  EXPECT_EQ(other["maps"]["misses"], 0) << other;
  EXPECT_EQ(other["maps"]["hits"], 2) << other;
  const json maps = json::parse(get(port_, "/v1/maps").body)["maps"];
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_EQ(maps[0]["kind"], "irradiance");
  EXPECT_EQ(maps[1]["kind"], "guide");
}

}  // namespace
}  // namespace photond::test
