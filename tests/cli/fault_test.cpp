// The real program, killed at random moments over a mix of jobs. Nothing that was acknowledged may be lost, and every
// picture must have the bits of an undisturbed one. PHOTOND_KILLS says how often (./run faults).
#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <thread>

#include "tests/cli/daemon.h"
#include "tests/cli/program.h"
#include "tests/server/http_client.h"
#include "tests/server/small_scene.h"

namespace photond::test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

/// A kind of job: it is submitted to stop at `first` and, where that is not its end, extended to `last`.
struct Kind {
  const char* settings;
  const char* first;
  const char* last;
};
constexpr Kind kKinds[] = {
    {R"("method":"path","film":{"width":48,"height":32})", R"({"passes":600})", R"({"passes":600})"},
    {R"("method":"progressive","photons_per_pass":8000,"film":{"width":32,"height":24})", R"({"passes":250})",
     R"({"passes":250})"},
    {R"("method":"path","seed":7,"priority":"batch","film":{"width":64,"height":64})", R"({"passes":120})",
     R"({"passes":300})"},
    {R"("method":"photon_map","photons_per_pass":20000,"film":{"width":16,"height":16})", R"({"passes":40})",
     R"({"passes":40})"},
    {R"("method":"path","film":{"width":40,"height":40})", R"({"relative_error":0.02,"passes":3000})",
     R"({"relative_error":0.02,"passes":3000})"},
};
constexpr int kKindCount = static_cast<int>(std::size(kKinds));

bool is_end(const std::string& state) { return state == "succeeded" || state == "failed" || state == "canceled"; }

class FaultTest : public ::testing::Test {
 protected:
  static std::string message(const std::string& scene, const Kind& kind, const char* stop) {
    return "{\"scene\":\"" + scene + "\"," + kind.settings + ",\"stop\":" + stop + "}";
  }

  static std::string upload(int port, const std::string& name) {
    const Reply reply = ask(port, "POST", "/v1/scenes", small_glb(name), "model/gltf-binary");
    return reply.status == 200 || reply.status == 201 ? parsed(reply).value("id", "") : "";
  }

  /// The picture of each kind of an undisturbed service.
  std::vector<std::string> references() {
    const TemporaryFolder data;
    Daemon daemon(data.file("data"));
    std::vector<std::string> pictures;
    if (!daemon.start()) return pictures;
    const std::string scene = upload(daemon.port, "scene");
    for (const Kind& kind : kKinds) {
      const json job = parsed(ask(daemon.port, "POST", "/v1/jobs", message(scene, kind, kind.last)));
      pictures.push_back(picture(daemon, wait_for_end(daemon, job.value("id", "?"))));
    }
    EXPECT_EQ(daemon.end(SIGTERM), 0) << "ends by itself and cleanly";
    return pictures;
  }

  json wait_for_end(Daemon& daemon, const std::string& id) {
    json job;
    for (const auto deadline = Clock::now() + 300s; Clock::now() < deadline; std::this_thread::sleep_for(10ms)) {
      job = parsed(ask(daemon.port, "GET", "/v1/jobs/" + id));
      if (job.is_object() && is_end(job.value("state", ""))) return job;
    }
    ADD_FAILURE() << "the job does not end: " << job;
    return job;
  }

  static std::string picture(Daemon& daemon, const json& job) {
    EXPECT_EQ(job.value("state", ""), "succeeded") << job;
    const Reply reply = ask(daemon.port, "GET", "/v1/jobs/" + job.value("id", "") + "/frames/latest.exr");
    EXPECT_EQ(reply.status, 200) << job;
    return reply.body;
  }
};

/// What has been acknowledged.
struct Acknowledged {
  std::mutex mutex;
  std::map<std::string, int> jobs;       ///< id → kind
  std::map<std::string, json> seen;      ///< as last seen
  std::set<std::string> scenes;
};

/// Submits, uploads, pauses and resumes until told to stop, whatever becomes of the service.
void disturb(Daemon& daemon, const std::string& scene, Acknowledged& known, const std::atomic<std::size_t>& most,
             const std::stop_token& stop, std::mt19937 random) {
  int uploads = 0;
  while (!stop.stop_requested()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5 + random() % 40));
    std::string some;
    std::size_t count = 0;
    {
      const std::lock_guard lock(known.mutex);
      count = known.jobs.size();
      if (count > 0) some = std::next(known.jobs.begin(), static_cast<std::ptrdiff_t>(random() % count))->first;
    }
    const std::uint32_t what = random() % 8;
    if (what < 4 && count < most) {
      const int kind = static_cast<int>(random() % kKindCount);
      const std::string text = std::string("{\"scene\":\"") + scene + "\"," + kKinds[kind].settings +
                               ",\"stop\":" + kKinds[kind].first + "}";
      const Reply reply = ask(daemon.port, "POST", "/v1/jobs", text);
      const std::lock_guard lock(known.mutex);
      if (reply.status == 202) known.jobs[parsed(reply).value("id", "?")] = kind;
    } else if (what == 4 && uploads < 100) {
      const Reply reply = ask(daemon.port, "POST", "/v1/scenes", small_glb("upload " + std::to_string(++uploads)),
                              "model/gltf-binary");
      const std::lock_guard lock(known.mutex);
      if (reply.status == 201) known.scenes.insert(parsed(reply).value("id", "?"));
    } else if (what >= 5 && !some.empty()) {
      ask(daemon.port, "POST", "/v1/jobs/" + some + (what == 5 ? "/pause" : "/resume"));
    }
  }
}

/// Every job that was acknowledged is known, has not gone back in time and, if it had ended, still has.
void check_nothing_lost(Daemon& daemon, Acknowledged& known) {
  const std::lock_guard lock(known.mutex);
  for (const auto& [id, kind] : known.jobs) {
    const Reply reply = ask(daemon.port, "GET", "/v1/jobs/" + id);
    EXPECT_EQ(reply.status, 200) << id << " is lost";
    const json job = parsed(reply);
    json& before = known.seen[id];
    if (before.is_object()) {
      EXPECT_GE(job.value("version", 0), before.value("version", 0)) << job;
      EXPECT_GE(job.value("revision", 0), before.value("revision", 0)) << job;
      if (before["state"] == "succeeded" && job["version"] == before["version"]) {
        EXPECT_EQ(job, before);
      }
    }
    EXPECT_NE(job.value("state", ""), "failed") << job;
    before = job;
  }
  for (const std::string& id : known.scenes) {
    EXPECT_EQ(ask(daemon.port, "GET", "/v1/scenes/" + id + ".glb").status, 200) << "scene " << id << " is lost";
  }
}

/// The id of the newest event.
std::uint64_t newest_event(Daemon& daemon) {
  Connection stream(daemon.port);
  stream.send("GET /v1/events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  const std::string& text = stream.read_until("retry: 2000\nid: ", 10s);
  const std::size_t at = text.find("id: ");
  return at == std::string::npos ? 0 : std::stoull(text.substr(at + 4));
}

TEST_F(FaultTest, KilledAtRandomNothingAcknowledgedIsLostAndTheBitsAreTheSame) {
  const char* asked = std::getenv("PHOTOND_KILLS");
  const int kills = asked ? std::atoi(asked) : 6;
  std::mt19937 random(20'26);
  const std::vector<std::string> wanted = references();
  ASSERT_EQ(wanted.size(), std::size(kKinds));

  const TemporaryFolder data;
  Daemon daemon(data.file("data"));
  ASSERT_TRUE(daemon.start());
  const std::string scene = upload(daemon.port, "scene");
  ASSERT_EQ(scene.size(), 64u);
  Acknowledged known;
  std::atomic<std::size_t> most = 6;
  std::jthread client([&, seed = random()](const std::stop_token& stop) {
    disturb(daemon, scene, known, most, stop, std::mt19937(seed));
  });
  std::uint64_t event = 0;
  for (int kill = 1; kill <= kills; ++kill) {
    // Mostly short lives, in which little is written down; but without longer ones no job would ever end.
    std::this_thread::sleep_for(std::chrono::milliseconds(20 + random() % (kill % 5 == 0 ? 4000 : 900)));
    if (kill % 2 == 0) event = std::max(event, newest_event(daemon));  // the other lives end without being asked
    daemon.end(SIGKILL);
    const Clock::time_point begin = Clock::now();
    ASSERT_TRUE(daemon.start());
    check_nothing_lost(daemon, known);
    const std::uint64_t now = newest_event(daemon);
    // The same only where a life was too short to tell anything.
    EXPECT_GE(now, event) << "ids of events go back";
    event = now;
    ++most;
    if (kill % 20 == 0) {
      const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
      std::cout << kill << " kills, " << known.jobs.size() << " jobs, " << known.scenes.size()
                << " uploads; up and checked again in " << seconds << " s" << std::endl;
    }
    if (HasFailure()) break;
  }
  client.request_stop();
  client.join();

  std::map<int, int> same;
  for (const auto& [id, kind] : known.jobs) {
    ask(daemon.port, "POST", "/v1/jobs/" + id + "/resume");
    json job = wait_for_end(daemon, id);
    if (std::string(kKinds[kind].first) != kKinds[kind].last) {
      const std::string stop = std::string("{\"stop\":") + kKinds[kind].last + "}";
      EXPECT_EQ(ask(daemon.port, "POST", "/v1/jobs/" + id + "/extend", stop).status, 202);
      job = wait_for_end(daemon, id);
    }
    const bool bits = picture(daemon, job) == wanted[static_cast<std::size_t>(kind)];
    EXPECT_TRUE(bits) << "other bits: " << job;
    same[kind] += bits;
  }
  EXPECT_EQ(daemon.end(SIGTERM), 0);
  std::cout << kills << " kills over " << known.jobs.size() << " jobs and " << known.scenes.size()
            << " uploads: nothing lost, the bits of every kind the same (";
  for (const auto& [kind, count] : same) std::cout << count << (kind == same.rbegin()->first ? ")\n" : ", ");
  EXPECT_GE(known.jobs.size(), 3u);
}

TEST_F(FaultTest, SigtermWritesRunningJobsDownAndEndsInTime) {
  const TemporaryFolder data;
  Daemon daemon(data.file("data"));
  ASSERT_TRUE(daemon.start());
  const std::string scene = upload(daemon.port, "scene");
  std::vector<std::string> ids;
  for (int i = 0; i < 4; ++i) {
    const Reply reply = ask(daemon.port, "POST", "/v1/jobs", "{\"scene\":\"" + scene +
        R"(","method":"path","film":{"width":600,"height":400},"stop":{"seconds":600}})");
    ASSERT_EQ(reply.status, 202);
    ids.push_back(parsed(reply).value("id", "?"));
  }
  const auto passes = [&](const std::string& id) {
    return parsed(ask(daemon.port, "GET", "/v1/jobs/" + id)).value("passes", 0);
  };
  for (const std::string& id : ids) {
    for (int i = 0; i < 3000 && passes(id) == 0; ++i) std::this_thread::sleep_for(10ms);
  }
  const Clock::time_point begin = Clock::now();
  EXPECT_EQ(daemon.end(SIGTERM), 0);
  EXPECT_LT(Clock::now() - begin, 20s);
  ASSERT_TRUE(daemon.start());
  for (const std::string& id : ids) EXPECT_GT(passes(id), 0);
}

}  // namespace
}  // namespace photond::test
