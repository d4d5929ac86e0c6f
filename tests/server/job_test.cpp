#include "server/jobs/job.h"

#include <gtest/gtest.h>

#include <thread>

#include "server/jobs/jobs.h"
#include "server/jobs/stop_rule.h"
#include "tests/server/temporary_store.h"

namespace photond {
namespace {

using namespace std::chrono_literals;

constexpr JobState kWay[] = {JobState::queued, JobState::preparing, JobState::rendering, JobState::finalizing,
                             JobState::succeeded};

class JobTest : public ::testing::Test {
 protected:
  std::shared_ptr<Job> new_job(const std::string& id) {
    JobRecord record;
    record.id = id;
    Event created;
    created.job = id;
    created.version = record.version;
    EXPECT_TRUE(log_.add(record, created).ok());
    return std::make_shared<Job>(record, log_);
  }

  const test::TemporaryStore stored_;
  Store& store_ = *stored_.store;
  EventLog log_{store_};
};

/// The states that may follow `from`, by name, in the order of the enum.
std::string after(JobState from) {
  std::string names;
  for (int to = 0; to < kJobStates; ++to) {
    if (may_move(from, static_cast<JobState>(to))) names += std::string(" ") + state_name(static_cast<JobState>(to));
  }
  return names;
}

TEST(JobStates, MoveAsTheyShould) {
  EXPECT_EQ(after(JobState::queued), " preparing canceling failed paused");
  EXPECT_EQ(after(JobState::preparing), " queued rendering canceling failed paused");
  EXPECT_EQ(after(JobState::rendering), " queued finalizing canceling failed paused");
  EXPECT_EQ(after(JobState::finalizing), " queued succeeded canceling failed paused");
  EXPECT_EQ(after(JobState::succeeded), " queued") << "extended";
  EXPECT_EQ(after(JobState::canceling), " canceled") << "who asked for that is not told of a failure";
  EXPECT_EQ(after(JobState::canceled), "");
  EXPECT_EQ(after(JobState::failed), " queued") << "tried again";
  EXPECT_EQ(after(JobState::paused), " queued canceling");
}

TEST(JobStates, HaveNamesThatReadBack) {
  for (int i = 0; i < kJobStates; ++i) {
    EXPECT_EQ(state_from_name(state_name(static_cast<JobState>(i))), static_cast<JobState>(i));
  }
  EXPECT_FALSE(state_from_name("resting"));
}

TEST_F(JobTest, EveryMoveIsStoredWithVersionTimeAndEvent) {
  const auto job = new_job("a");
  for (int i = 1; i < 5; ++i) ASSERT_TRUE(job->move(kWay[i]).ok());
  const auto stored = store_.job("a");
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->state, JobState::succeeded);
  EXPECT_EQ(stored->version, 5u);
  EXPECT_TRUE(stored->started && stored->finished);
  const auto events = log_.read_after(0, "a");
  ASSERT_EQ(events.size(), 5u);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(events[i].state, kWay[i]);
    EXPECT_EQ(events[i].version, static_cast<std::uint64_t>(i + 1));
  }
}

TEST_F(JobTest, AnIllegalMoveChangesNothing) {
  const auto job = new_job("a");
  const Status moved = job->move(JobState::finalizing, [](JobRecord& record) { record.passes = 9; });
  ASSERT_FALSE(moved.ok());
  EXPECT_EQ(moved.error().code, ErrorCode::conflict);
  EXPECT_EQ(job->record().passes, 0u);
  EXPECT_EQ(log_.read_after(0, "a").size(), 1u);
}

TEST_F(JobTest, TheReasonOfAPauseEndsWithIt) {
  const auto job = new_job("a");
  ASSERT_TRUE(job->move(JobState::paused, [](JobRecord& r) { r.pause_reason = PauseReason::disk_full; }).ok());
  EXPECT_EQ(store_.job("a")->pause_reason, PauseReason::disk_full);
  ASSERT_TRUE(job->move(JobState::queued).ok());
  EXPECT_EQ(store_.job("a")->pause_reason, PauseReason::none);
}

TEST_F(JobTest, APauseForRoomBecomesOneByRequest) {
  const auto job = new_job("a");
  ASSERT_TRUE(job->move(JobState::paused, [](JobRecord& r) { r.pause_reason = PauseReason::disk_full; }).ok());
  ASSERT_TRUE(job->pause().ok());
  EXPECT_EQ(store_.job("a")->state, JobState::paused);
  EXPECT_EQ(store_.job("a")->pause_reason, PauseReason::request);
  const std::uint64_t version = job->record().version;
  ASSERT_TRUE(job->pause().ok());
  EXPECT_EQ(job->record().version, version) << "again: nothing is new";
  ASSERT_TRUE(job->move(JobState::queued).ok());
  ASSERT_TRUE(job->pause().ok());
  EXPECT_EQ(job->state(), JobState::paused) << "one that goes on just then is paused, too";
  ASSERT_TRUE(job->move(JobState::canceling).ok());
  EXPECT_EQ(job->pause().error().code, ErrorCode::conflict);
  EXPECT_EQ(job->record().pause_reason, PauseReason::none);
}

TEST_F(JobTest, AnEndedJobThatGoesOnHasNotFinished) {
  const auto job = new_job("a");
  ASSERT_TRUE(job->move(JobState::preparing).ok());
  const auto started = job->record().started;
  ASSERT_TRUE(job->move(JobState::failed).ok());
  EXPECT_TRUE(job->record().finished);
  ASSERT_TRUE(job->move(JobState::queued).ok());
  EXPECT_FALSE(job->record().finished);
  ASSERT_TRUE(job->move(JobState::preparing).ok());
  EXPECT_EQ(job->record().started, started) << "the first time counts";
}

TEST_F(JobTest, AReaderFindsProgressCoalescedButEveryState) {
  const auto job = new_job("a");
  ASSERT_TRUE(job->move(JobState::preparing).ok());
  ASSERT_TRUE(job->move(JobState::rendering).ok());
  for (std::uint32_t i = 1; i <= 1000; ++i) {
    ASSERT_TRUE(job->note(EventKind::progress, [i](JobRecord& record) { record.passes = i; }).ok());
  }
  const auto events = log_.read_after(0, "a");
  ASSERT_EQ(events.size(), 4u);
  EXPECT_EQ(events[2].state, JobState::rendering);
  EXPECT_EQ(events[3].kind, EventKind::progress);
  EXPECT_EQ(events[3].passes, 1000u);
  EXPECT_TRUE(log_.read_after(events[3].id, "a").empty());
}

TEST_F(JobTest, WaitingEndsByAnEventByTimeOrByAStop) {
  const auto job = new_job("a");
  const std::uint64_t seen = log_.newest();
  EXPECT_FALSE(log_.wait_beyond(seen, 1ms, {}));
  std::thread writer([&] {
    std::this_thread::sleep_for(10ms);
    EXPECT_TRUE(job->move(JobState::preparing).ok());
  });
  EXPECT_TRUE(log_.wait_beyond(seen, 10s, {}));
  writer.join();
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(log_.wait_beyond(log_.newest(), 10s, stop.get_token()));
}

TEST_F(JobTest, EventsOfDifferentJobsKeepTheirOrder) {
  const auto a = new_job("a");
  const auto b = new_job("b");
  ASSERT_TRUE(b->move(JobState::preparing).ok());
  ASSERT_TRUE(a->move(JobState::preparing).ok());
  const auto events = log_.read_after(0, "");
  std::string order;
  for (const Event& event : events) order += event.job;
  EXPECT_EQ(order, "abba");
  EXPECT_EQ(log_.read_after(0, "b").size(), 2u);
}

TEST(RevisionRule, PublishesAtPassesSpacedByRootTwo) {
  RevisionRule rule;
  std::vector<std::uint32_t> published;
  for (std::uint32_t pass = 1; pass <= 100; ++pass) {
    if (rule.due(pass, pass)) published.push_back(pass);
  }
  const std::vector<std::uint32_t> expected{1, 2, 3, 4, 6, 8, 11, 16, 23, 32, 42, 45, 55, 64, 74, 84, 91};
  EXPECT_EQ(published, expected) << "with a second per pass the limit of ten seconds cuts in after 32";
}

TEST(RevisionRule, KeepsHalfASecondAndReachesAtMostTen) {
  RevisionRule fast;
  double last = -1;
  for (std::uint32_t pass = 1; pass <= 10'000; ++pass) {
    const double now = pass * 0.001;
    if (!fast.due(pass, now)) continue;
    if (last >= 0) {
      EXPECT_GE(now - last, 0.5);
    }
    last = now;
  }
  RevisionRule slow;
  EXPECT_TRUE(slow.due(1000, 0));
  EXPECT_FALSE(slow.due(1001, 9.9));
  EXPECT_TRUE(slow.due(1002, 10));
}

TEST(Scenes, CameraIsChosenByIndexNameOrPlacement) {
  std::vector<Camera> cameras(2);
  cameras[1].name = "main";
  EXPECT_EQ(choose_camera(cameras, 1u)->name, "main");
  EXPECT_EQ(choose_camera(cameras, std::string("main"))->name, "main");
  EXPECT_EQ(choose_camera(cameras, LookAt{{0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 90})->yfov, glm::radians(90.f));
  for (const CameraChoice& wrong : {CameraChoice(2u), CameraChoice(std::string("other"))}) {
    const auto camera = choose_camera(cameras, wrong);
    ASSERT_FALSE(camera.ok());
    EXPECT_EQ(camera.error().where, "/camera");
  }
  EXPECT_EQ(choose_camera(cameras, 2u).error().message, "/camera must be from 0 to 1");
  EXPECT_EQ(choose_camera(cameras, std::string("other")).error().message, "there is no camera 'other'; there are '', 'main'");
  EXPECT_EQ(choose_camera(std::vector<Camera>(10), std::string("x")).error().message,
            "there is no camera 'x'; there are '', '', '', '', '', '', '', '' and 2 more");
}

}  // namespace
}  // namespace photond
