#include "server/store/store.h"

#include <gtest/gtest.h>

#include <fstream>
#include <future>
#include <limits>

#include "server/store/record_text.h"
#include "tests/server/temporary_store.h"

namespace photond {
namespace {

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

/// A record in which every member has a value of its own.
JobRecord full_record() {
  JobRecord job;
  job.id = "j-1";
  job.sequence = 3;
  job.owner = "k-1";
  job.spec.scene = sha256(bytes_of("scene"));
  job.spec.camera = LookAt{{1, 2, 3}, {4, 5, 6}, {0, 0, 1}, 55.5f};
  job.spec.photons = {1000, UINT64_MAX};
  job.spec.settings = {Method::progressive, 30, 20, UINT64_MAX, 0.1f, 7, 9};
  job.spec.stop = {100, 0.1, std::nullopt};
  job.spec.priority = Priority::batch;
  job.spec.label = "a \"label\" \xc3\xa4";
  job.state = JobState::paused;
  job.version = 77;
  job.created = WallTime(std::chrono::milliseconds(1'700'000'000'123));
  job.started = WallTime(std::chrono::milliseconds(1'700'000'000'456));
  job.plan = Plan{Method::path, true, true, 0.3f, {{"method", true, "because"}, {"radius", false, ""}}};
  job.passes = 12;
  job.seconds = 1.0 / 3;
  job.rejected = 4;
  job.error = ErrorEstimate{0.1, 0.2, 0.3, 0.4, 5, true};
  job.eta_seconds = 9.5;
  job.map_hits = 6;
  job.map_misses = 7;
  job.revision = 8;
  job.least_error = 0.15;
  job.first_frame_seconds = 0.25;
  job.failure = Error{ErrorCode::io, "message", "/where"};
  job.pause_reason = PauseReason::disk_full;
  job.crashes = 2;
  return job;
}

Event event_of(const JobRecord& job, EventKind kind = EventKind::state) {
  Event event;
  event.kind = kind;
  event.job = job.id;
  event.state = job.state;
  event.version = job.version;
  event.passes = job.passes;
  return event;
}

TEST(RecordText, ReadsBackAsItWas) {
  const JobRecord job = full_record();
  const std::string text = record_text(job);
  const auto back = read_record(text);
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(record_text(*back), text);
  EXPECT_EQ(back->seconds, job.seconds) << "to the last bit";
  EXPECT_EQ(back->spec.settings.seed, UINT64_MAX);
  EXPECT_EQ(back->spec.label, job.spec.label);
  EXPECT_EQ(back->started, job.started);
  EXPECT_FALSE(back->finished);
  EXPECT_EQ(std::get<LookAt>(back->spec.camera).yfov_deg, 55.5f);
  EXPECT_EQ(back->plan->items[0].reason, "because");
  JobRecord named = job, indexed = job;
  named.spec.camera = std::string("7");
  indexed.spec.camera = 7u;
  EXPECT_EQ(std::get<std::string>(read_record(record_text(named))->spec.camera), "7");
  EXPECT_EQ(std::get<std::uint32_t>(read_record(record_text(indexed))->spec.camera), 7u);
}

TEST(RecordText, WhatIsNotFiniteStaysSo) {
  JobRecord job = full_record();
  job.error->relative = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(std::isfinite(read_record(record_text(job))->error->relative));
}

TEST(RecordText, AMemberThatIsMissingHasItsDefault) {
  const auto job = read_record(R"({"id":"x","later":[1,2]})");
  ASSERT_TRUE(job.ok());
  EXPECT_EQ(job->id, "x");
  EXPECT_EQ(job->version, JobRecord().version);
}

TEST(RecordText, OtherTextIsAnError) {
  for (const char* text : {"", "{", "[]", "7", R"({"id":7})", R"({"spec":{"settings":{"method":"none"}}})",
                           R"({"plan":{"items":[3]}})", R"({"state":"queued"})", R"({"spec":{"scene":"12"}})"}) {
    EXPECT_FALSE(read_record(text).ok()) << text;
  }
}

class StoreTest : public ::testing::Test {
 protected:
  JobRecord add(const std::string& id) {
    JobRecord job;
    job.id = id;
    EXPECT_TRUE(store().add_job(job, event_of(job)).ok());
    return job;
  }
  SceneRecord scene(const std::string& content, bool sample = false) {
    const SceneRecord record{sha256(bytes_of(content)), sample ? "sample" : "", "model/gltf-binary",
                             content.size(),            sample,                 WallTime(std::chrono::seconds(9))};
    EXPECT_TRUE(store().put_scene(record, bytes_of(content)).ok());
    return record;
  }
  Store& store() { return *stored_.store; }

  test::TemporaryStore stored_;
};

TEST_F(StoreTest, JobsEventsAndSeriesSurvive) {
  JobRecord job = full_record();
  job.revision = 1;
  job.series = {{1, 1, 0.5, std::nullopt}};
  ASSERT_TRUE(store().add_job(job, event_of(job)).ok());
  job.series.push_back({2, 4, 1.5, ErrorEstimate{1, 2, 3, 4, 5, true}});
  job.passes = 44;
  ASSERT_TRUE(store().update_job(job, event_of(job, EventKind::frame)).ok());
  const auto events = store().events_after(0, "");
  stored_.open();
  const auto back = store().job("j-1");
  ASSERT_TRUE(back);
  EXPECT_EQ(record_text(*back), record_text(job));
  EXPECT_FALSE(back->series.empty()) << "the first points came with an update";
  EXPECT_EQ(back->series.back().error->bias, 4);
  const auto after = store().events_after(0, "");
  ASSERT_EQ(after.size(), events.size());
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_EQ(event_text(after[i]), event_text(events[i]));
}

TEST_F(StoreTest, EventIdsAscendForEver) {
  std::uint64_t last = 0;
  for (int life = 0; life < 3; ++life) {
    JobRecord job = add("j-" + std::to_string(life));
    for (int i = 0; i < 700; ++i) {
      const auto event = store().update_job(job, event_of(job, i % 10 ? EventKind::progress : EventKind::state));
      ASSERT_TRUE(event.ok());
      ASSERT_GT(event->id, last);
      last = event->id;
    }
    EXPECT_TRUE(store().remove_job(job.id).ok());
    stored_.open();
    EXPECT_GE(store().newest_event(), last);
  }
}

TEST_F(StoreTest, WhatIsGoneIsTold) {
  const JobRecord job = add("a");
  add("b");
  const std::uint64_t before = store().newest_event();
  ASSERT_TRUE(store().remove_job("a").ok());
  EXPECT_FALSE(store().remove_job("a").ok());
  for (int life = 0; life < 2; ++life) {
    for (const char* of : {"", "a"}) {
      const auto events = store().events_after(before, of);
      ASSERT_EQ(events.size(), 1u) << of;
      EXPECT_EQ(events[0].kind, EventKind::gone);
      EXPECT_EQ(events[0].job, "a");
      EXPECT_EQ(events[0].version, job.version);
    }
    EXPECT_TRUE(store().events_after(before, "b").empty());
    EXPECT_TRUE(store().is_gone("a"));
    EXPECT_FALSE(store().is_gone("b"));
    stored_.open();
  }
}

TEST_F(StoreTest, OfWhatIsGoneTheNewestThousandAreKept) {
  for (int i = 0; i < 1030; ++i) {
    add(std::to_string(i));
    ASSERT_TRUE(store().remove_job(std::to_string(i)).ok());
  }
  for (int life = 0; life < 2; ++life) {
    EXPECT_EQ(store().events_after(0, "").size(), 1024u);
    EXPECT_FALSE(store().is_gone("5"));
    EXPECT_TRUE(store().is_gone("6"));
    stored_.open();
  }
}

TEST_F(StoreTest, SequenceNumbersAreNotGivenTwice) {
  const JobRecord first = add("a"), second = add("b");
  EXPECT_TRUE(store().remove_job("b").ok());
  stored_.open();
  EXPECT_GT(add("c").sequence, second.sequence);
  EXPECT_GT(second.sequence, first.sequence);
  const auto jobs = store().jobs();
  ASSERT_EQ(jobs.size(), 2u);
  EXPECT_EQ(jobs[0].id, "c") << "newest first";
}

TEST_F(StoreTest, OnlyTheNewestProgressIsKeptButEveryState) {
  JobRecord job = add("a");
  for (std::uint32_t i = 1; i <= 10; ++i) {
    job.passes = i;
    for (const EventKind kind : {EventKind::progress, EventKind::frame, EventKind::state}) {
      ASSERT_TRUE(store().update_job(job, event_of(job, kind)).ok());
    }
  }
  for (int life = 0; life < 2; ++life) {
    const auto events = store().events_after(0, "a");
    EXPECT_EQ(events.size(), 13u);
    for (const Event& event : events) {
      if (event.kind != EventKind::state) {
        EXPECT_EQ(event.passes, 10u);
      }
    }
    stored_.open();
  }
}

TEST_F(StoreTest, StateEventsAreBounded) {
  JobRecord job = add("a");
  for (int i = 0; i < 300; ++i) ASSERT_TRUE(store().update_job(job, event_of(job)).ok());
  EXPECT_EQ(store().events_after(0, "a").size(), 256u);
  stored_.open();
  EXPECT_EQ(store().events_after(0, "a").size(), 256u);
}

TEST_F(StoreTest, WhatIsUnknownIsNotUpdated) {
  JobRecord job;
  job.id = "nobody";
  EXPECT_EQ(store().update_job(job, event_of(job)).error().code, ErrorCode::not_found);
  add("a");
  job.id = "a";
  EXPECT_EQ(store().add_job(job, event_of(job)).error().code, ErrorCode::conflict);
}

TEST_F(StoreTest, AJobAndWhatComesWithItAreOneTransaction) {
  JobRecord job;
  job.id = "a";
  const auto refused = store().add_job(job, event_of(job), [](Transaction&) -> Status { return cancelled(); });
  EXPECT_FALSE(refused.ok());
  EXPECT_FALSE(store().job("a"));
  stored_.open();
  EXPECT_FALSE(store().job("a"));
}

TEST_F(StoreTest, ScenesSurviveInTheOrderTheyCame) {
  const SceneRecord a = scene("a"), b = scene("b"), s = scene("s", true);
  scene("a");
  for (int life = 0; life < 2; ++life) {
    const auto scenes = store().scenes();
    ASSERT_EQ(scenes.size(), 3u);
    EXPECT_EQ(scenes[0].id, s.id) << "samples first";
    EXPECT_EQ(scenes[1].id, a.id);
    EXPECT_EQ(scenes[2].id, b.id);
    EXPECT_EQ(scenes[1].created, a.created);
    EXPECT_EQ(**store().scene_bytes(a.id), bytes_of("a"));
    stored_.open();
    scene("s", true);  // as at each start
  }
  EXPECT_TRUE(store().remove_scene(a.id).ok());
  EXPECT_TRUE(store().remove_scene(a.id).ok());
  stored_.open();
  EXPECT_FALSE(store().scene(a.id));
  EXPECT_EQ(store().scene_bytes(a.id).error().code, ErrorCode::not_found);
  EXPECT_FALSE(std::filesystem::exists(stored_.folder.path() / "scenes" / to_hex(a.id)));
}

TEST_F(StoreTest, ADamagedSampleIsMendedAtTheNextStart) {
  const SceneRecord s = scene("sample", true);
  std::ofstream(store().scene_files().path_of(s.id)) << "?";
  stored_.open();
  scene("sample", true);
  EXPECT_EQ(**store().scene_bytes(s.id), bytes_of("sample"));
}

TEST_F(StoreTest, ScenesOfAnOlderFileAreNobodys) {
  const SceneRecord known = scene("a");
  stored_.store.reset();
  stored_.files.reset();
  stored_.database.reset();
  const std::string path = stored_.folder.file("photond.db");
  std::filesystem::remove(path);
  {
    const auto older = Database::open(path, schema().first(4));
    ASSERT_TRUE(older.ok());
    const Status put = (*older)->write([&](Transaction& transaction) {
      return transaction.run("INSERT INTO scenes VALUES (?, 1, '', 'model/gltf-binary', 1, 0, 0)",
                             std::as_bytes(std::span(known.id.bytes)));
    });
    ASSERT_TRUE(put.ok());
  }
  stored_.open();
  ASSERT_EQ(store().scenes().size(), 1u);
  EXPECT_EQ(store().scenes()[0].owner, "");
}

TEST_F(StoreTest, AFileWithoutARowIsSwept) {
  const std::string orphan = to_hex(sha256(bytes_of("orphan")));
  std::ofstream(stored_.folder.path() / "scenes" / orphan) << "orphan";
  stored_.open();
  EXPECT_FALSE(std::filesystem::exists(stored_.folder.path() / "scenes" / orphan));
}

class JobFilesTest : public StoreTest {
 protected:
  void SetUp() override {
    add("a");
    add("b");
  }
  JobFiles& files() { return *stored_.files; }
  Status checkpoint(const std::string& job, std::uint32_t passes, const std::string& content) {
    return files().put_checkpoint(job, passes, passes * 0.5,
                                  [&](const Blobs::Sink& sink) { return sink(bytes_of(content)); });
  }
};

TEST_F(JobFilesTest, PicturesSurviveAndStayAsTheyWere) {
  ASSERT_TRUE(files().put_frame("a", 1, FrameFormat::png, bytes_of("one")).ok());
  ASSERT_TRUE(files().put_frame("a", 1, FrameFormat::png, bytes_of("other")).ok());
  ASSERT_TRUE(files().put_frame("a", 1, FrameFormat::exr, bytes_of("exr")).ok());
  stored_.open();
  EXPECT_EQ(**files().frame("a", 1, FrameFormat::png), bytes_of("one"));
  EXPECT_EQ(**files().frame("a", 1, FrameFormat::exr), bytes_of("exr"));
  EXPECT_EQ(files().frame("a", 1, FrameFormat::jpg).error().code, ErrorCode::not_found);
  EXPECT_EQ(files().frame("a", 2, FrameFormat::png).error().code, ErrorCode::not_found);
  EXPECT_EQ(files().frame_files().total_bytes(), 6u) << "the one that was not wanted is swept";
}

TEST_F(JobFilesTest, ASharedFileGoesWithItsLastRow) {
  ASSERT_TRUE(files().put_frame("a", 1, FrameFormat::png, bytes_of("same")).ok());
  ASSERT_TRUE(files().put_frame("b", 1, FrameFormat::png, bytes_of("same")).ok());
  ASSERT_TRUE(files().drop_frames("a").ok());
  EXPECT_TRUE(files().frame("b", 1, FrameFormat::png).ok());
  ASSERT_TRUE(files().drop_frames("b").ok());
  EXPECT_EQ(files().frame_files().total_bytes(), 0u);
}

TEST_F(JobFilesTest, TwoCheckpointsAreKept) {
  for (std::uint32_t passes = 1; passes <= 4; ++passes) {
    ASSERT_TRUE(checkpoint("a", passes, "film " + std::to_string(passes)).ok());
  }
  stored_.open();
  const auto kept = files().checkpoints("a");
  ASSERT_EQ(kept->size(), 2u);
  EXPECT_EQ(kept->at(0).passes, 4u);
  EXPECT_EQ(kept->at(0).seconds, 2);
  EXPECT_EQ(kept->at(0).bytes, 6u);
  EXPECT_EQ(**files().read(kept->at(1)), bytes_of("film 3"));
  ASSERT_TRUE(files().drop_checkpoints("a", 1).ok());
  EXPECT_EQ(files().checkpoints("a")->size(), 1u);
  ASSERT_TRUE(files().drop_checkpoints("a").ok());
  EXPECT_EQ(files().checkpoint_files().total_bytes(), 0u);
}

TEST_F(JobFilesTest, NobodyWaitsForACheckpointThatIsBeingWritten) {
  ASSERT_TRUE(checkpoint("a", 1, "film").ok());
  std::future<Status> other;
  const Status written = files().put_checkpoint("b", 1, 1, [&](const Blobs::Sink& sink) {
    other = std::async(std::launch::async, [&] { return files().drop_checkpoints("a"); });
    EXPECT_EQ(other.wait_for(std::chrono::seconds(1)), std::future_status::ready);
    return sink(bytes_of("film"));
  });
  EXPECT_TRUE(written.ok());
  EXPECT_TRUE(other.get().ok());
  const auto kept = files().checkpoints("b");
  EXPECT_EQ(**files().read(kept->at(0)), bytes_of("film")) << "though what was dropped was the same";
}

TEST_F(JobFilesTest, NothingStaysOfAJobThatIsGone) {
  ASSERT_TRUE(store().remove_job("a").ok());
  EXPECT_FALSE(checkpoint("a", 1, "film").ok());
  EXPECT_FALSE(files().put_frame("a", 1, FrameFormat::png, bytes_of("picture")).ok());
  EXPECT_EQ(files().checkpoint_files().total_bytes() + files().frame_files().total_bytes(), 0u);
  ASSERT_TRUE(checkpoint("b", 1, "film").ok());
  ASSERT_TRUE(store().remove_job("b").ok());
  stored_.open();
  EXPECT_EQ(files().checkpoint_files().total_bytes(), 0u) << "swept, its row went with the job";
}

}  // namespace
}  // namespace photond
