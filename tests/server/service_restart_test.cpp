#include <fstream>

#include "tests/server/service_fixture.h"

namespace photond::test {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

/// A new service on the same data is what a restart is; tests/cli/fault_test.cpp does kill -9 to the real program.
class RestartTest : public ServiceTest {
 protected:
  Reply post(const std::string& id, const std::string& what) {
    return request(port_, "POST", "/v1/jobs/" + id + "/" + what);
  }
  Reply extend(const std::string& id, const std::string& stop) {
    return post_json(port_, "/v1/jobs/" + id + "/extend", "{\"stop\":" + stop + "}");
  }
  std::string exr(const std::string& id) { return get(port_, "/v1/jobs/" + id + "/frames/latest.exr").body; }
  std::string passes(int n) { return R"("method":"progressive","photons_per_pass":20000,"stop":{"passes":)" + std::to_string(n) + "}"; }
  /// The picture of an undisturbed job.
  std::string undisturbed(int n) {
    const std::string id = submit(scene_, passes(n));
    EXPECT_EQ(wait_for_end(id)["state"], "succeeded");
    return exr(id);
  }
  void SetUp() override {
    ServiceTest::SetUp();
    scene_ = upload();
  }

  std::string scene_;
};

TEST_F(RestartTest, AFinishedJobKeepsItsPicturesAndEvents) {
  const std::string id = submit(scene_, passes(4));
  const json before = wait_for_end(id);
  const std::string frame = before["urls"]["frame"];
  std::map<std::string, Reply> pictures;
  for (const char* format : {".png", ".jpg", ".exr"}) pictures[format] = get(port_, frame + format);
  const std::string series = get(port_, before["urls"]["series"]).body;
  restart();
  EXPECT_EQ(job(id), before);
  EXPECT_EQ(get(port_, before["urls"]["series"]).body, series);
  for (auto& [format, picture] : pictures) {
    ASSERT_EQ(picture.status, 200);
    const Reply again = get(port_, frame + format);
    EXPECT_TRUE(again.body == picture.body) << format;
    EXPECT_EQ(again.headers.at("etag"), picture.headers.at("etag"));
  }
  EXPECT_EQ(get(port_, "/v1/jobs/" + id + "/frames/latest.png").headers.at("content-location"), frame + ".png");
  const std::string events = get(port_, "/v1/jobs/" + id + "/events").body;
  EXPECT_NE(events.find("\"state\":\"succeeded\""), std::string::npos) << events;
  EXPECT_EQ(request(port_, "DELETE", "/v1/jobs/" + id).status, 204);
  for (const char* folder : {"frames", "checkpoints"}) {
    EXPECT_TRUE(std::filesystem::is_empty(data_->path() / "data" / folder)) << folder;
  }
}

TEST_F(RestartTest, ARunningJobGoesOnByItselfToTheSameBits) {
  const std::string undisturbed_exr = undisturbed(300);
  const std::string id = submit(scene_, passes(300));
  int lives = 1;
  std::uint64_t version = 0;
  while (true) {
    for (int i = 0; i < 200 && job(id)["passes"] == 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (job(id)["state"] == "succeeded" || lives == 5) break;
    const Clock::time_point begin = Clock::now();
    restart();
    EXPECT_LT(Clock::now() - begin, std::chrono::seconds(10));
    ++lives;
    EXPECT_GT(job(id)["version"].get<std::uint64_t>(), version);
    version = job(id)["version"];
    EXPECT_GT(job(id)["passes"], 0) << "passes are kept over a stop";
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  const json done = wait_for_end(id);
  EXPECT_EQ(done["state"], "succeeded") << done;
  EXPECT_EQ(done["passes"], 300);
  EXPECT_GE(lives, 2) << "the job was too short to be interrupted";
  EXPECT_TRUE(exr(id) == undisturbed_exr);
}

TEST_F(RestartTest, StoppingPutsJobsAsideQuickly) {
  const std::string id = submit(scene_, R"("method":"path","film":{"width":1500,"height":1500},"stop":{"seconds":600})");
  const std::string waiting = submit(scene_, passes(3));
  wait_for_state(id, "rendering");
  const Clock::time_point begin = Clock::now();
  service_->stop();
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(5));
  EXPECT_EQ(get(port_, "/healthz").status, 0);
  restart();
  EXPECT_EQ(wait_for_end(waiting)["state"], "succeeded");
  EXPECT_EQ(post(id, "cancel").status, 202);
  EXPECT_EQ(wait_for_end(id)["state"], "canceled");
  restart();
  EXPECT_EQ(job(id)["state"], "canceled");
}

TEST_F(RestartTest, APausedJobRestsUntilItIsResumed) {
  const std::string undisturbed_exr = undisturbed(200);
  const std::string id = submit(scene_, passes(200));
  while (job(id)["passes"] == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  ASSERT_EQ(post(id, "pause").status, 202);
  EXPECT_EQ(post(id, "pause").status, 202) << "asking again is no error";
  const json paused = wait_for_state(id, "paused");
  EXPECT_EQ(paused["paused_because"], "request");
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const json rested = job(id);
  EXPECT_LT(rested["passes"], 200);
  restart();
  EXPECT_EQ(job(id)["state"], "paused") << "also over a restart";
  EXPECT_EQ(job(id)["passes"], rested["passes"]);
  EXPECT_EQ(get(port_, "/v1/jobs/" + id + "/frames/latest.png").status, 200) << "its picture can be seen";
  EXPECT_EQ(post(id, "retry").status, 409);
  ASSERT_EQ(post(id, "resume").status, 202);
  EXPECT_EQ(post(id, "resume").status, 202);
  const json done = wait_for_end(id);
  EXPECT_EQ(done["state"], "succeeded") << done;
  EXPECT_TRUE(done["paused_because"].is_null());
  EXPECT_TRUE(exr(id) == undisturbed_exr);
  EXPECT_EQ(post(id, "pause").status, 409);
  EXPECT_EQ(post(id, "resume").status, 409);
  EXPECT_EQ(post("j-none", "pause").status, 404);
}

TEST_F(RestartTest, PausingAndResumingInQuickSuccessionLosesNothing) {
  const std::string undisturbed_exr = undisturbed(60);
  const std::string id = submit(scene_, passes(60));
  for (int i = 0; i < 40; ++i) {
    const int paused = post(id, "pause").status;
    if (paused == 409) break;  // it was quicker
    EXPECT_EQ(paused, 202);
    if (i % 3 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(i));
    EXPECT_EQ(post(id, "resume").status, 202);
    if (i % 5 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(i));
  }
  EXPECT_EQ(wait_for_end(id)["state"], "succeeded");
  EXPECT_TRUE(exr(id) == undisturbed_exr);
}

TEST_F(RestartTest, APausedJobCanBeCanceled) {
  const std::string id = submit(scene_, R"("method":"path","stop":{"seconds":600})");
  wait_for_state(id, "rendering");
  ASSERT_EQ(post(id, "pause").status, 202);
  restart();
  ASSERT_EQ(post(id, "cancel").status, 202);
  EXPECT_EQ(wait_for_end(id)["state"], "canceled");
  EXPECT_EQ(post(id, "resume").status, 409);
  EXPECT_EQ(request(port_, "DELETE", "/v1/jobs/" + id).status, 204);
}

TEST_F(RestartTest, ASucceededJobIsExtendedToTheBitsOfALongerOne) {
  const std::string longer = undisturbed(90);
  const std::string id = submit(scene_, passes(50));
  const json first = wait_for_end(id);
  const std::string first_exr = exr(id);
  restart();
  EXPECT_EQ(extend(id, R"({"passes":0})").status, 422);
  EXPECT_EQ(extend(id, R"({})").status, 422);
  EXPECT_EQ(post_json(port_, "/v1/jobs/" + id + "/extend", "{}").status, 422);
  for (const char* met : {R"({"passes":20})", R"({"passes":49,"seconds":600})", R"({"seconds":1e-9})"}) {
    const Reply refused = extend(id, met);
    EXPECT_EQ(refused.status, 422) << met;
    EXPECT_EQ(json::parse(refused.body)["pointer"], "/stop") << met;
  }
  EXPECT_EQ(extend(id, R"({"passes":50})").status, 202) << "there already";
  EXPECT_EQ(wait_for_end(id)["revision"], first["revision"]) << "nothing of it is done again";
  ASSERT_EQ(extend(id, R"({"passes":90})").status, 202);
  const int again = extend(id, R"({"passes":90})").status;
  EXPECT_EQ(again, 202) << "on its way there";
  const json done = wait_for_end(id);
  EXPECT_EQ(done["state"], "succeeded") << done;
  EXPECT_EQ(done["passes"], 90);
  EXPECT_EQ(done["spec"]["stop"]["passes"], 90);
  EXPECT_TRUE(exr(id) == longer);
  EXPECT_TRUE(get(port_, first["urls"]["frame"].get<std::string>() + ".exr").body == first_exr)
      << "the earlier result stays what it was";
  const std::string running = submit(scene_, R"("method":"path","stop":{"seconds":600})");
  EXPECT_EQ(extend(running, R"({"passes":90})").status, 409);
  EXPECT_EQ(post(running, "cancel").status, 202);
  wait_for_end(running);
  EXPECT_EQ(extend(running, R"({"passes":90})").status, 409);
}

TEST_F(RestartTest, AJobWhoseSceneIsGoneStaysAsItEnded) {
  const std::string id = submit(scene_, passes(2));
  const json done = wait_for_end(id);
  EXPECT_EQ(request(port_, "DELETE", "/v1/scenes/" + scene_).status, 204);
  const Reply refused = extend(id, R"({"passes":4})");
  EXPECT_EQ(refused.status, 409);
  EXPECT_NE(json::parse(refused.body)["detail"].get<std::string>().find("there is no scene"), std::string::npos);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_EQ(job(id), done);
  upload();
  EXPECT_EQ(extend(id, R"({"passes":4})").status, 202);
  EXPECT_EQ(wait_for_end(id)["passes"], 4);
}

TEST_F(RestartTest, AFailedJobSaysWhyAndCanBeRetried) {
  const std::string id = submit(scene_, passes(5));
  wait_for_end(id);
  ASSERT_EQ(post(id, "pause").status, 409);
  const std::string failing = submit(scene_, R"("method":"path","stop":{"seconds":600})");
  wait_for_state(failing, "rendering");
  ASSERT_EQ(post(failing, "pause").status, 202);
  restart();
  // The scene's file is lost: what was paused cannot be prepared again.
  std::ofstream(data_->path() / "data" / "scenes" / scene_, std::ios::binary) << "rubbish";
  ASSERT_EQ(post(failing, "resume").status, 202);
  const json failed = wait_for_end(failing);
  EXPECT_EQ(failed["state"], "failed");
  EXPECT_NE(failed["problem"]["detail"].get<std::string>().find("damaged"), std::string::npos) << failed;
  restart();
  EXPECT_EQ(job(failing)["problem"], failed["problem"]);
  EXPECT_EQ(post(failing, "retry").status, 409) << "the scene is gone";
  upload();
  ASSERT_EQ(post(failing, "retry").status, 202);
  const json again = wait_for_state(failing, "rendering");
  EXPECT_TRUE(again["problem"].is_null());
  EXPECT_TRUE(again["finished_at"].is_null());
  EXPECT_EQ(post(failing, "cancel").status, 202);
  wait_for_end(failing);
  EXPECT_EQ(post(failing, "retry").status, 409);
}

TEST_F(RestartTest, ADamagedCheckpointIsNotedAndTheOneBeforeItUsed) {
  const std::string undisturbed_exr = undisturbed(200);
  for (const bool all : {false, true}) {
    const std::string id = submit(scene_, passes(200));
    while (job(id)["passes"] == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ASSERT_EQ(post(id, "pause").status, 202);
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    service_.reset();
    // The newest of the files, or every one.
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(data_->path() / "data" / "checkpoints")) {
      files.push_back(entry.path());
    }
    ASSERT_FALSE(files.empty());
    std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
      return std::filesystem::last_write_time(a) > std::filesystem::last_write_time(b);
    });
    if (!all) files.resize(1);
    for (const auto& file : files) {
      std::fstream damaged(file, std::ios::binary | std::ios::in | std::ios::out);
      damaged.seekp(5000);
      damaged << "damage";
    }
    restart();
    ASSERT_EQ(post(id, "resume").status, 202);
    EXPECT_EQ(wait_for_end(id)["state"], "succeeded");
    EXPECT_TRUE(exr(id) == undisturbed_exr);
  }
}

TEST_F(RestartTest, EventIdsGoOnAndALateReaderMissesNoState) {
  const std::string id = submit(scene_, R"("method":"path","stop":{"seconds":600})");
  wait_for_state(id, "rendering");
  restart();
  wait_for_state(id, "rendering");
  EXPECT_EQ(post(id, "cancel").status, 202);
  wait_for_end(id);
  const std::string events = get(port_, "/v1/jobs/" + id + "/events").body;
  std::uint64_t last = 0;
  std::string states;
  std::istringstream lines(events);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("id: ", 0) == 0) {
      const std::uint64_t event = std::stoull(line.substr(4));
      EXPECT_GE(event, last);
      last = event;
    }
    if (line.rfind("data: ", 0) == 0) {
      const std::string state = json::parse(line.substr(6))["state"];
      if (states.size() < state.size() || states.substr(states.size() - state.size()) != state) states += " " + state;
    }
  }
  EXPECT_EQ(states, " queued preparing rendering queued preparing rendering canceling canceled") << events;
}

}  // namespace
}  // namespace photond::test
