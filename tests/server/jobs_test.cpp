#include "server/jobs/jobs.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/server/small_scene.h"
#include "tests/server/temporary_store.h"

namespace photond {
namespace {

using namespace std::chrono_literals;

class JobsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string glb = test::small_glb();
    const auto bytes = std::as_bytes(std::span(glb));
    const auto added = jobs_.scenes().add({bytes.begin(), bytes.end()}, "model/gltf-binary", "", {}, {});
    ASSERT_TRUE(added.ok()) << added.error().message;
    endless_.scene = added->scene.id;
    endless_.camera = 0u;
    endless_.settings.method = Method::path;
    endless_.settings.width = endless_.settings.height = 8;
    endless_.stop.seconds = 600;
  }

  static JobLimits limits() {
    JobLimits limits;
    limits.threads = 1;
    limits.disk = {64 << 20, 0};
    return limits;
  }
  bool has_scene() { return stored_.store->scene(endless_.scene).has_value(); }

  const test::TemporaryStore stored_;
  Jobs jobs_{*stored_.store, *stored_.environments, *stored_.files, stored_.folder.path(),
             [](const RenderTask&) { return Result<std::string>("this"); }, limits(), nullptr};
  JobSpec endless_;
};

TEST_F(JobsTest, ASceneThatGoesWhileAJobIsCheckedIsMissed) {
  const auto first = jobs_.submit(endless_, {}, {});
  ASSERT_TRUE(first.ok()) << first.error().message;
  std::thread submits;
  // Whoever changes a job is waited for, by then the new job has been checked.
  const auto during = [&](const JobRecord&) -> Status {
    submits = std::thread([&] {
      const auto second = jobs_.submit(endless_, {}, {});
      ASSERT_FALSE(second.ok());
      EXPECT_EQ(second.error().code, ErrorCode::not_found);
      EXPECT_EQ(second.error().where, "/scene");
    });
    std::this_thread::sleep_for(300ms);
    return stored_.store->remove_scene(endless_.scene);
  };
  EXPECT_TRUE(jobs_.resume(first->id, during).ok());
  submits.join();
}

TEST_F(JobsTest, NoJobComesWhoseSceneIsJustGoingForRoom) {
  std::thread submits;
  std::atomic<bool> coming = false, submitted = false;
  const auto also = [&](Transaction&, const JobRecord&) -> Status {
    coming = true;
    std::this_thread::sleep_for(300ms);
    return Done{};
  };
  // Maps are what goes first.
  const auto free = [&](std::uint64_t) -> std::uint64_t {
    submits = std::thread([&] { submitted = jobs_.submit(endless_, {}, {}, also).ok(); });
    for (int i = 0; i < 50 && !coming; ++i) std::this_thread::sleep_for(10ms);
    return 0;
  };
  jobs_.room().set_maps({[] { return 1 << 20; }, free});
  const DiskUse use = measure_disk(stored_.folder.path(), limits().disk).value();
  (void)jobs_.room().make_room(use.limit - use.used + 1).ok();
  submits.join();
  EXPECT_EQ(submitted, has_scene());
}

TEST_F(JobsTest, OfTwoExtensionsAtOnceOneIsRefused) {
  JobSpec short_job = endless_;
  short_job.stop = {.passes = 1};
  for (int i = 0; i < 50; ++i) {
    const std::string id = jobs_.submit(short_job, {}, {})->id;
    while (jobs_.job(id)->state() != JobState::succeeded) std::this_thread::sleep_for(1ms);
    std::atomic<int> ready = 0, extended = 0;
    const auto extend = [&](double seconds) {
      ++ready;
      while (ready < 2) std::this_thread::yield();
      const auto job = jobs_.extend(id, {.seconds = seconds}, {});
      extended += job ? 1 : 0;
      EXPECT_TRUE(job ? job->spec.stop.seconds == seconds : job.error().code == ErrorCode::conflict);
    };
    std::thread other([&] { extend(600); });
    extend(900);
    other.join();
    EXPECT_EQ(extended, 1);
    ASSERT_TRUE(jobs_.cancel(id).ok());
  }
}

}  // namespace
}  // namespace photond
