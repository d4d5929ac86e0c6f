#include "server/jobs/jobs.h"

#include <gtest/gtest.h>

#include <atomic>
#include <optional>
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
  /// A job of so many passes, once it has ended.
  JobRecord ended(std::uint32_t passes, std::uint64_t seed = 0) {
    JobSpec spec = endless_;
    spec.stop = {.passes = passes};
    spec.settings.seed = seed;
    const std::string id = jobs_.submit(spec, {}, {})->id;
    while (jobs_.job(id)->state() != JobState::succeeded) std::this_thread::sleep_for(1ms);
    return jobs_.job(id)->record();
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

TEST_F(JobsTest, AnExtensionToAnErrorThatWasReachedIsRefused) {
  for (const std::uint32_t passes : {8u, 17u, 23u}) {
    const JobRecord job = ended(passes);
    const auto extended = jobs_.extend(job.id, {.relative_error = job.error->relative * 1.01}, {});
    ASSERT_FALSE(extended.ok()) << passes;
    EXPECT_EQ(extended.error().code, ErrorCode::invalid_input);
    EXPECT_EQ(extended.error().where, "/stop");
  }
  const JobRecord young = ended(7);
  ASSERT_TRUE(jobs_.extend(young.id, {.relative_error = 1e6}, {}).ok()) << "so few passes say too little";
  while (jobs_.job(young.id)->state() != JobState::succeeded) std::this_thread::sleep_for(1ms);
  EXPECT_EQ(jobs_.job(young.id)->record().passes, 8u);
}

TEST_F(JobsTest, AnErrorThatWasReachedOnTheWayCountsToo) {
  std::optional<double> reached;
  JobRecord job;
  for (std::uint64_t seed = 0; seed < 50 && !reached; ++seed) {
    const double before = ended(8, seed).error->relative;
    job = ended(9, seed);
    if (job.error->relative > 1.001 * before) reached = before;
  }
  ASSERT_TRUE(reached) << "noise makes the estimate grow now and then";
  const auto extended = jobs_.extend(job.id, {.relative_error = (*reached + job.error->relative) / 2}, {});
  ASSERT_FALSE(extended.ok()) << "a job with this rule from the start has 8 passes";
  EXPECT_EQ(extended.error().where, "/stop");
  EXPECT_TRUE(jobs_.extend(job.id, {.relative_error = *reached / 2}, {}).ok());
}

TEST_F(JobsTest, OfASucceededJobOnlyTheCheckpointOfAllItsPassesIsServed) {
  const JobRecord job = ended(3);
  const auto put = [&](std::uint32_t passes) {
    return stored_.files->put_checkpoint(job.id, passes, 1, [](const Blobs::Sink& sink) {
      return sink(std::as_bytes(std::span("sum", 3)));
    });
  };
  ASSERT_TRUE(put(2).ok());
  const auto none = jobs_.checkpoint(job.id);
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, ErrorCode::not_found);
  ASSERT_TRUE(put(3).ok());
  ASSERT_TRUE(jobs_.checkpoint(job.id).ok());
  EXPECT_EQ(jobs_.checkpoint(job.id)->about.passes, 3u);
}

}  // namespace
}  // namespace photond
