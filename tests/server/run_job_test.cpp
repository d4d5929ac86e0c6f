#include "server/jobs/run_job.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <new>
#include <optional>
#include <thread>

#include "server/jobs/environment_library.h"
#include "tests/server/small_scene.h"
#include "tests/server/temporary_store.h"

namespace photond {
namespace {

/// One job of a small scene, and what its run needs.
class RunJobTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string glb = test::small_glb();
    const auto bytes = std::as_bytes(std::span(glb));
    const auto added = scenes_.add({bytes.begin(), bytes.end()}, "model/gltf-binary", "", {}, {});
    ASSERT_TRUE(added.ok()) << added.error().message;
    scene_ = added->scene.id;
  }

  JobRecord new_record() const {
    JobRecord record;
    record.id = "a";
    record.spec.scene = scene_;
    record.spec.camera = 0u;
    record.spec.settings.method = Method::path;
    record.spec.settings.width = record.spec.settings.height = 8;
    record.spec.stop.passes = 3;
    return record;
  }
  std::shared_ptr<Job> new_job() { return new_job(new_record()); }
  std::shared_ptr<Job> new_job(JobRecord record) {
    Event created;
    created.job = record.id;
    EXPECT_TRUE(log_.add(record, created).ok());
    return std::make_shared<Job>(record, log_);
  }

  const test::TemporaryStore stored_;
  EventLog log_{*stored_.store};
  const Workers workers_{1};
  DiskRoom room_{stored_.folder.path(), {}, *stored_.store, *stored_.environments, *stored_.files};
  Turn turn_{stored_.folder.path() / "turn"};
  EnvironmentLibrary environments_{*stored_.environments, room_, 0};
  SceneLibrary scenes_{*stored_.store, environments_, room_, workers_, 0};
  MapCache maps_{0, nullptr};
  std::atomic<std::uint64_t> passes_{0};
  RunParts parts_{scenes_, maps_, workers_, *stored_.files, room_, turn_, passes_, UINT64_MAX,
                  [](const RenderTask&) { return Result<std::string>("this"); }, std::chrono::milliseconds(0)};
  Digest scene_;
};

TEST_F(RunJobTest, EndsWhatItsStopRuleNames) {
  RunJob run(new_job(), parts_);
  while (run.step()) continue;
  EXPECT_EQ(run.job()->state(), JobState::succeeded);
  EXPECT_EQ(run.job()->record().passes, 3u);
}

TEST_F(RunJobTest, HasAPassThoughPreparingTookAllItsTime) {
  JobRecord record = new_record();
  record.spec.stop = {.seconds = 1e-9};
  RunJob run(new_job(record), parts_);
  while (run.step()) continue;
  EXPECT_EQ(run.job()->state(), JobState::succeeded);
  EXPECT_EQ(run.job()->record().passes, 1u) << "of none the picture is black";
}

TEST_F(RunJobTest, CountsTheMapsOfThePassesThatItHas) {
  JobRecord record = new_record();
  record.spec.settings.method = Method::progressive;
  record.spec.photons.photons_per_pass = 1000;
  const auto job = new_job(record);
  const auto run_once = [&] {
    RunJob run(job, parts_);
    while (run.step()) continue;
    EXPECT_EQ(job->record().passes, 3u);
    return job->record().map_hits + job->record().map_misses;
  };
  const std::uint64_t first = run_once();
  EXPECT_GE(first, 3u);
  ASSERT_TRUE(stored_.files->drop_checkpoints("a", 0).ok());
  ASSERT_TRUE(job->move(JobState::queued).ok());
  EXPECT_EQ(run_once(), first) << "it has begun anew";
}

/// A process that dies in the turn of `job`, and the next one.
Turn death_of(const std::filesystem::path& file, const std::string& job) {
  Turn(file).give(job);
  return Turn(file);
}

TEST_F(RunJobTest, TheJobInWhoseTurnTheServiceDiesAgainAndAgainFails) {
  const auto ours = new_job();
  JobRecord other = new_record();
  other.id = "b";
  const auto theirs = new_job(other);
  for (int death = 1; death <= 5; ++death) {
    for (const auto& job : {ours, theirs}) ASSERT_TRUE(job->move(JobState::preparing).ok());
    turn_ = death_of(stored_.folder.path() / "turn", "a");
    for (const auto& job : {ours, theirs}) ASSERT_TRUE(RunJob(job, parts_).put_back().ok());
    EXPECT_EQ(ours->state(), death < 5 ? JobState::queued : JobState::failed) << death;
    EXPECT_EQ(theirs->state(), JobState::queued) << "it merely waited";
  }
  EXPECT_EQ(theirs->record().crashes, 0u);
  EXPECT_EQ(Turn(stored_.folder.path() / "turn").last(), "") << "nobody computes";
  EXPECT_EQ(Turn("/nowhere/turn").last(), "");
}

TEST_F(RunJobTest, HasTheTurnOnlyWhileItComputes) {
  std::string during;
  parts_.identity = [&](const RenderTask&) {
    during = Turn(stored_.folder.path() / "turn").last();
    return Result<std::string>("this");
  };
  RunJob run(new_job(), parts_);
  EXPECT_TRUE(run.step());
  EXPECT_EQ(during, "a");
  EXPECT_EQ(Turn(stored_.folder.path() / "turn").last(), "");
}

TEST_F(RunJobTest, AJobThatWouldTakeTooMuchMemoryIsNotBegun) {
  parts_.max_memory_bytes = 20'000;
  RunJob run(new_job(), parts_);
  while (run.step()) continue;
  EXPECT_EQ(run.job()->state(), JobState::failed);
  EXPECT_EQ(run.job()->record().failure->code, ErrorCode::limit_exceeded);
  EXPECT_EQ(run.job()->record().failure->where, "/film");
  EXPECT_EQ(passes_, 0u);
}

TEST_F(RunJobTest, WhatIsThrownFailsTheJobAndItsRunLetsGoAllTheSame) {
  parts_.identity = [](const RenderTask&) -> Result<std::string> { throw std::bad_alloc(); };
  RunJob run(new_job(), parts_);
  const auto content = [](const char* text) {
    return [text](const Blobs::Sink& sink) { return sink(std::as_bytes(std::span(text, 3))); };
  };
  ASSERT_TRUE(stored_.files->put_checkpoint("a", 1, 1, content("one")).ok());
  ASSERT_TRUE(stored_.files->put_checkpoint("a", 2, 2, content("two")).ok());
  EXPECT_FALSE(run.step());
  EXPECT_EQ(run.job()->state(), JobState::failed);
  EXPECT_EQ(run.job()->record().failure->code, ErrorCode::internal);
  EXPECT_EQ(stored_.files->checkpoints("a")->size(), 1u) << "of a job that failed one is kept, to be tried again";
}

/// Of one pixel, so that what others want comes between passes, too.
JobRecord tiny(JobRecord record) {
  record.spec.settings.width = record.spec.settings.height = 1;
  record.spec.stop.passes = 1'000'000;
  return record;
}

TEST_F(RunJobTest, IsPutAwayWheneverItIsPaused) {
  RunJob run(new_job(tiny(new_record())), parts_);
  Job& job = *run.job();
  for (int i = 0; i < 40; ++i) {
    ASSERT_TRUE(i == 0 || job.move(JobState::queued).ok());
    std::thread renders([&] { while (run.step()) continue; });
    for (const std::uint64_t before = passes_; passes_ < before + 3;) std::this_thread::yield();
    EXPECT_TRUE(job.move(JobState::paused).ok());
    run.interrupt();
    renders.join();
    const auto checkpoints = stored_.files->checkpoints("a");
    ASSERT_FALSE(checkpoints->empty()) << i;
    ASSERT_EQ(checkpoints->front().passes, job.record().passes) << i;
    ASSERT_TRUE(stored_.files->frame("a", job.record().revision, FrameFormat::png).ok()) << i;
  }
}

TEST_F(RunJobTest, IsPutAwayWheneverTheServiceEnds) {
  const auto job = new_job(tiny(new_record()));
  for (int i = 0; i < 40; ++i) {
    RunJob run(job, parts_);
    std::thread renders([&] { while (run.step()) continue; });
    for (const std::uint64_t before = passes_; passes_ < before + 3;) std::this_thread::yield();
    run.drain();
    renders.join();
    ASSERT_EQ(job->state(), JobState::queued) << i;
    ASSERT_EQ(job->record().passes, passes_) << i;
    ASSERT_EQ(stored_.files->checkpoints("a")->front().passes, passes_) << i;
  }
}

TEST_F(RunJobTest, WhatHasACheckpointEndsWithOneOfAllItsPasses) {
  JobRecord record = tiny(new_record());
  record.spec.stop = {.seconds = 0.4};
  RunJob run(new_job(record), parts_);
  std::thread renders;
  {
    const auto held = room_.hold();  // its first checkpoint, after .2 s, takes so long that no other is worth it
    renders = std::thread([&] { while (run.step()) continue; });
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
  }
  renders.join();
  ASSERT_EQ(run.job()->state(), JobState::succeeded);
  EXPECT_EQ(stored_.files->checkpoints("a")->front().passes, run.job()->record().passes);
}

class TightDiskTest : public RunJobTest {
 protected:
  /// With room for so many films of the job more than there is now.
  void limit(double films) {
    const std::uint64_t used = measure_disk(stored_.folder.path(), {}).value().used;
    const std::uint64_t film = stored_.files->checkpoints("a")->front().bytes;
    tight_.emplace(stored_.folder.path(), DiskLimits{used + static_cast<std::uint64_t>(films * film), 0}, *stored_.store,
                   *stored_.environments, *stored_.files);
    tight_parts_.emplace(RunParts{scenes_, maps_, workers_, *stored_.files, *tight_, turn_, passes_, UINT64_MAX,
                                  parts_.identity, std::chrono::milliseconds(0)});
  }
  JobRecord large() {
    JobRecord record = new_record();
    record.spec.settings.width = record.spec.settings.height = 96;
    record.spec.stop.passes = 1'000'000;
    return record;
  }
  /// Of a run that begins with this: until one more pass is done and put away.
  static void pass_and_rest(RunJob& run) {
    ASSERT_TRUE(run.job()->state() == JobState::queued || run.job()->move(JobState::queued).ok());
    for (const std::uint32_t before = run.job()->record().passes; run.job()->record().passes == before;) {
      ASSERT_TRUE(run.step());
      if (run.job()->state() == JobState::rendering) {
        ASSERT_TRUE(run.step());
        ASSERT_TRUE(run.job()->move(JobState::paused).ok());
        run.step();
      }
    }
  }
  std::vector<std::uint32_t> checkpoints() const {
    std::vector<std::uint32_t> passes;
    const auto kept = stored_.files->checkpoints("a");
    for (const auto& checkpoint : *kept) passes.push_back(checkpoint.passes);
    return passes;
  }

  std::optional<DiskRoom> tight_;
  std::optional<RunParts> tight_parts_;
};

TEST_F(TightDiskTest, AnOlderCheckpointGivesItsRoomToANewOne) {
  const auto job = new_job(large());
  RunJob first(job, parts_);
  for (int i = 0; i < 2; ++i) pass_and_rest(first);
  EXPECT_EQ(checkpoints(), (std::vector<std::uint32_t>{2, 1}));
  limit(.7);
  RunJob run(job, *tight_parts_);
  pass_and_rest(run);
  EXPECT_FALSE(run.unsaved());
  EXPECT_EQ(checkpoints(), (std::vector<std::uint32_t>{3, 2}));
}

TEST_F(TightDiskTest, AJobThatDaresGoesOnWithoutACheckpointUntilThereIsRoom) {
  const auto job = new_job(large());
  RunJob first(job, parts_);
  pass_and_rest(first);
  limit(.7);
  RunJob run(job, *tight_parts_);
  ASSERT_TRUE(job->move(JobState::queued).ok());
  while (run.step()) continue;
  EXPECT_EQ(job->record().pause_reason, PauseReason::disk_full);
  EXPECT_GT(run.missing_bytes(), 0u);
  const std::uint64_t before = passes_;
  ASSERT_TRUE(job->move(JobState::queued).ok());
  run.dare();
  while (passes_ < before + 5) ASSERT_TRUE(run.step());
  EXPECT_EQ(checkpoints(), std::vector<std::uint32_t>{1});
}

TEST_F(TightDiskTest, AJobThatEndsWithoutRoomForItsLastPassesEndsAllTheSame) {
  JobRecord record = large();
  record.spec.stop.passes = 2;
  const auto job = new_job(record);
  RunJob first(job, parts_);
  pass_and_rest(first);
  limit(.7);
  RunJob run(job, *tight_parts_);
  ASSERT_TRUE(job->move(JobState::queued).ok());
  while (run.step()) continue;
  EXPECT_EQ(job->state(), JobState::succeeded);
  EXPECT_EQ(checkpoints(), std::vector<std::uint32_t>{1});
}

TEST_F(RunJobTest, WaitsForAFolderThatIsOutOfReachAndLosesNothing) {
  RunJob before(new_job(), parts_);
  Job& job = *before.job();
  while (passes_ < 2) ASSERT_TRUE(before.step());
  ASSERT_TRUE(job.move(JobState::paused).ok());
  EXPECT_FALSE(before.step());
  for (const char* name : {"scenes", "checkpoints"}) {
    ASSERT_TRUE(job.move(JobState::queued).ok());
    const auto folder = stored_.folder.path() / name, away = stored_.folder.path() / "away";
    std::filesystem::rename(folder, away);
    RunJob run(before.job(), parts_);
    while (run.step()) continue;
    EXPECT_EQ(job.state(), JobState::paused) << name;
    EXPECT_EQ(job.record().pause_reason, PauseReason::disk_unreachable) << name;
    std::filesystem::rename(away, folder);
  }
  ASSERT_TRUE(job.move(JobState::queued).ok());
  RunJob after(before.job(), parts_);
  while (after.step()) continue;
  EXPECT_EQ(job.state(), JobState::succeeded);
  EXPECT_EQ(passes_, 3u) << "it goes on from its checkpoint";
}

TEST_F(RunJobTest, WaitsForADescriptor) {
  RunJob run(new_job(), parts_);
  rlimit before{};
  ::getrlimit(RLIMIT_NOFILE, &before);
  const rlimit none{static_cast<rlim_t>(0), before.rlim_max};
  ::setrlimit(RLIMIT_NOFILE, &none);
  while (run.step()) continue;
  ::setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_EQ(run.job()->state(), JobState::paused);
  EXPECT_EQ(run.job()->record().pause_reason, PauseReason::disk_unreachable);
  ASSERT_TRUE(run.job()->move(JobState::queued).ok());
  while (run.step()) continue;
  EXPECT_EQ(run.job()->state(), JobState::succeeded);
}

TEST_F(RunJobTest, WhatCannotBePutAwayRestsUntilItCan) {
  RunJob run(new_job(tiny(new_record())), parts_);
  while (passes_ < 3) ASSERT_TRUE(run.step());
  ASSERT_TRUE(run.job()->move(JobState::paused).ok());
  const auto folder = stored_.folder.path() / "checkpoints", away = stored_.folder.path() / "away";
  std::filesystem::rename(folder, away);
  EXPECT_FALSE(run.step()) << "it does not try for ever";
  EXPECT_TRUE(run.unsaved());
  std::filesystem::rename(away, folder);
  ASSERT_TRUE(run.claim());
  EXPECT_FALSE(run.step());
  EXPECT_FALSE(run.unsaved());
  EXPECT_EQ(stored_.files->checkpoints("a")->front().passes, 3u);
  EXPECT_EQ(run.job()->state(), JobState::paused);
}

}  // namespace
}  // namespace photond
