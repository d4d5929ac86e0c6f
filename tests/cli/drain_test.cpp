// The end of the real program when something takes longer than it may.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <thread>

#include "server/cli/cli.h"
#include "tests/cli/daemon.h"
#include "tests/server/small_scene.h"

namespace photond::test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

class DrainTest : public ::testing::Test {
 protected:
  /// A film of a hundred megabytes: putting it away takes far longer than the service gives it.
  static std::string submit(Daemon& daemon) {
    const Reply scene = ask(daemon.port, "POST", "/v1/scenes", small_glb(), "model/gltf-binary");
    const Reply job = ask(daemon.port, "POST", "/v1/jobs",
                          "{\"scene\":\"" + parsed(scene).value("id", "") +
                              R"(","method":"path","film":{"width":700,"height":600},"stop":{"passes":40}})");
    EXPECT_EQ(job.status, 202) << job.body;
    return "/v1/jobs/" + parsed(job).value("id", "");
  }

  template <class Done>
  static json wait_until(Daemon& daemon, const std::string& job, const Done& done) {
    json now;
    for (const auto deadline = Clock::now() + 120s; Clock::now() < deadline; std::this_thread::sleep_for(10ms)) {
      now = parsed(ask(daemon.port, "GET", job));
      if (now.is_object() && done(now)) return now;
    }
    ADD_FAILURE() << "in vain: " << now;
    return now;
  }

  static std::string picture(Daemon& daemon, const std::string& job) {
    wait_until(daemon, job, [](const json& now) { return now.value("state", "") == "succeeded"; });
    return ask(daemon.port, "GET", job + "/frames/latest.exr").body;
  }
};

TEST_F(DrainTest, EndsInTimeWhateverTakesLonger) {
  const TemporaryFolder undisturbed;
  Daemon reference(undisturbed.file("data"));
  ASSERT_TRUE(reference.start());
  const std::string expected = picture(reference, submit(reference));
  EXPECT_EQ(reference.end(SIGTERM), 0) << "what is done in time ends as ever";

  const TemporaryFolder folder;
  Daemon daemon(folder.file("data"));
  ASSERT_TRUE(daemon.start({"--drain-seconds", "0.01"}));
  const std::string job = submit(daemon);
  while (ask(daemon.port, "GET", job + "/checkpoint").status != 200) std::this_thread::sleep_for(10ms);
  const int passes = parsed(ask(daemon.port, "GET", job)).value("passes", 0);
  // One pass beyond the checkpoint, so that there is something to put away.
  wait_until(daemon, job, [&](const json& now) { return now.value("passes", 0) > passes; });
  const Clock::time_point begin = Clock::now();
  const int status = daemon.end(SIGTERM);
  EXPECT_LT(Clock::now() - begin, 2s);
  ASSERT_TRUE(WIFEXITED(status)) << status;
  EXPECT_EQ(WEXITSTATUS(status), kExitCut);
  EXPECT_NE(daemon.said().find("\"event\":\"drain_cut\""), std::string::npos) << daemon.said();

  ASSERT_TRUE(daemon.start());
  EXPECT_EQ(picture(daemon, job), expected) << "it goes on from its last checkpoint to the same bits";
}

TEST_F(DrainTest, TwoSignalsAtOnceAreOne) {
  const TemporaryFolder folder;
  Daemon daemon(folder.file("data"));
  ASSERT_TRUE(daemon.start());
  daemon.send(SIGHUP);
  EXPECT_EQ(daemon.end(SIGTERM), 0);
}

TEST_F(DrainTest, EndsWhereNoThreadCanBeMade) {
  const TemporaryFolder folder;
  Daemon daemon(folder.file("data"));
  ASSERT_TRUE(daemon.start());
  daemon.limit_memory();
  EXPECT_EQ(daemon.end(SIGTERM), 0) << daemon.said();
}

}  // namespace
}  // namespace photond::test
