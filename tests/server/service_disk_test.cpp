#include <fstream>

#include "server/jobs/disk_room.h"
#include "server/store/file.h"
#include "tests/server/service_fixture.h"
#include "tests/server/temporary_store.h"

namespace photond::test {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMegabyte = 1 << 20;

std::vector<std::byte> bytes_of(std::size_t size, int seed) {
  return std::vector<std::byte>(size, static_cast<std::byte>(seed));
}

class DiskRoomTest : public ::testing::Test {
 protected:
  SceneRecord scene(int seed, bool sample = false) {
    const auto bytes = bytes_of(100'000, seed);
    const SceneRecord record{sha256(bytes), "", "model/gltf-binary", bytes.size(), sample, WallTime()};
    EXPECT_TRUE(stored_.store->put_scene(record, bytes).ok());
    return record;
  }
  EnvironmentRecord environment(int seed) {
    const auto bytes = bytes_of(100'000, seed);
    const EnvironmentRecord record{sha256(bytes), "image/x-exr", bytes.size(), 1, 1, {}, WallTime()};
    EXPECT_TRUE(stored_.environments->put(record, bytes).ok());
    return record;
  }
  bool has_environment(const EnvironmentRecord& record) { return stored_.environments->find(record.id)->has_value(); }
  void job(const std::string& id, JobState state, const Digest& scene, std::optional<Digest> environment = {}) {
    JobRecord job;
    job.id = id;
    job.state = state;
    job.spec.scene = scene;
    if (environment) job.spec.environment = EnvironmentChoice{.id = *environment};
    Event event;
    event.job = id;
    ASSERT_TRUE(stored_.store->add_job(job, event).ok());
    const int seed = id.back();
    ASSERT_TRUE(stored_.files->put_frame(id, 1, FrameFormat::png, bytes_of(100'000, seed)).ok());
    const auto content = [&](const Blobs::Sink& sink) { return sink(bytes_of(100'000, 100 + seed)); };
    ASSERT_TRUE(stored_.files->put_checkpoint(id, 1, 1, content).ok());
  }
  DiskRoom room(std::uint64_t quota) {
    return DiskRoom(stored_.folder.path(), {quota, 0}, *stored_.store, *stored_.environments, *stored_.files);
  }
  std::uint64_t used() { return measure_disk(stored_.folder.path(), {}).value().used; }
  bool has_frame(const std::string& id) { return stored_.files->frame(id, 1, FrameFormat::png).ok(); }
  bool has_checkpoint(const std::string& id) { return !stored_.files->checkpoints(id)->empty(); }

  TemporaryStore stored_;
};

TEST_F(DiskRoomTest, WhatCanBeMissedGoesInOrder) {
  const SceneRecord idle = scene(1), needed = scene(2), sample = scene(3, true);
  const EnvironmentRecord idle_sky = environment(4), needed_sky = environment(5);
  job("j-old", JobState::succeeded, idle.id, idle_sky.id);
  job("j-new", JobState::succeeded, idle.id);
  job("j-live", JobState::paused, needed.id, needed_sky.id);
  std::uint64_t asked = 0;
  const std::uint64_t all = used();
  const auto free = [&](std::uint64_t bytes) {
    DiskRoom room = this->room(used());
    room.set_maps({[] { return 0; }, [&](std::uint64_t wanted) { return asked = wanted; }});
    return room.make_room(bytes);
  };
  EXPECT_TRUE(free(50'000).ok());
  EXPECT_GE(asked, 50'000u) << "maps first";
  EXPECT_FALSE(has_checkpoint("j-old"));
  EXPECT_TRUE(has_checkpoint("j-new") && has_frame("j-old"));
  EXPECT_TRUE(free(150'000).ok());
  EXPECT_FALSE(has_checkpoint("j-new") || has_frame("j-old"));
  EXPECT_TRUE(has_frame("j-new"));
  EXPECT_TRUE(free(150'000).ok());
  EXPECT_FALSE(has_frame("j-new"));
  EXPECT_FALSE(stored_.store->scene(idle.id));
  EXPECT_TRUE(has_environment(idle_sky));
  EXPECT_TRUE(free(50'000).ok());
  EXPECT_FALSE(has_environment(idle_sky));
  EXPECT_TRUE(has_environment(needed_sky));
  const Status none = free(1);
  ASSERT_FALSE(none.ok()) << "what is left is needed";
  EXPECT_TRUE(is_disk_full(none.error()));
  EXPECT_TRUE(has_frame("j-live") && has_checkpoint("j-live"));
  EXPECT_TRUE(stored_.store->scene(needed.id) && stored_.store->scene(sample.id));
  EXPECT_EQ(stored_.store->jobs().size(), 3u) << "jobs themselves are small";
  EXPECT_LT(used(), all);
}

TEST_F(DiskRoomTest, OlderCheckpointsOfLiveJobsGoLastAndTheNewestThatIsWholeStays) {
  const SceneRecord needed = scene(1);
  for (const char* id : {"j-damaged", "j-other", "j-own"}) {
    job(id, JobState::paused, needed.id);
    const auto newer = [&](const Blobs::Sink& sink) { return sink(bytes_of(100'000, 150 + id[3])); };
    ASSERT_TRUE(stored_.files->put_checkpoint(id, 2, 2, newer).ok());
  }
  const auto passes = [&](const std::string& id) {
    std::vector<std::uint32_t> all;
    const auto rows = stored_.files->checkpoints(id);
    for (const auto& checkpoint : *rows) all.push_back(checkpoint.passes);
    return all;
  };
  const auto damaged = stored_.files->checkpoints("j-damaged")->front().blob;
  std::filesystem::remove(stored_.folder.path() / "checkpoints" / to_hex(damaged));
  const auto free = [&](std::uint64_t bytes) { return room(used()).make_room(bytes, "j-own"); };
  EXPECT_TRUE(is_disk_full(free(310'000).error())) << "more than all of them";
  EXPECT_EQ(passes("j-own").size(), 2u);
  EXPECT_TRUE(free(50'000).ok());
  EXPECT_EQ(passes("j-own"), std::vector<std::uint32_t>{2});
  EXPECT_EQ(passes("j-other").size(), 2u);
  EXPECT_TRUE(free(50'000).ok());
  EXPECT_EQ(passes("j-other"), std::vector<std::uint32_t>{2});
  EXPECT_FALSE(free(50'000).ok());
  EXPECT_EQ(passes("j-damaged").back(), 1u);
}

TEST_F(DiskRoomTest, WhatCannotMakeEnoughRoomStays) {
  const SceneRecord idle = scene(1), needed = scene(2);
  const EnvironmentRecord idle_sky = environment(4);
  job("j-old", JobState::succeeded, idle.id, idle_sky.id);
  job("j-live", JobState::paused, needed.id);
  // Equal jobs have the same files: these do not go twice, nor while one of the jobs lives.
  job("k-old", JobState::succeeded, idle.id);
  job("k-live", JobState::paused, needed.id);
  ASSERT_TRUE(stored_.files->put_frame("k-old", 2, FrameFormat::png, bytes_of(100'000, 'e')).ok());
  const std::uint64_t all = used();
  DiskRoom room = this->room(all);
  std::uint64_t asked = 0;
  room.set_maps({[] { return 100'000; }, [&](std::uint64_t wanted) { return asked = wanted; }});
  for (const std::uint64_t bytes : {all + 1, std::uint64_t{520'000}}) {
    const Status none = room.make_room(bytes);
    ASSERT_FALSE(none.ok());
    EXPECT_TRUE(is_disk_full(none.error()));
    EXPECT_EQ(asked, 0u);
    EXPECT_TRUE(has_frame("j-old") && has_checkpoint("j-old"));
    EXPECT_TRUE(stored_.store->scene(idle.id) && has_environment(idle_sky));
  }
  EXPECT_EQ(used(), all);
  room.set_maps({});
  EXPECT_TRUE(room.make_room(390'000).ok());
  EXPECT_FALSE(has_frame("j-old") || stored_.store->scene(idle.id) || has_environment(idle_sky));
}

TEST_F(DiskRoomTest, IsTidiedFromTheHighWaterMarkToTheLowOne) {
  const SceneRecord s = scene(1);
  for (char name = 'a'; name < 'k'; ++name) job(std::string("j-") + name, JobState::succeeded, s.id);
  const std::uint64_t before = used();
  DiskRoom wide = room(before * 100 / 85);
  EXPECT_TRUE(wide.tidy().ok());
  EXPECT_EQ(used(), before) << "between the marks nothing is done";
  DiskRoom narrow = room(before * 100 / 95);
  EXPECT_TRUE(narrow.tidy().ok());
  EXPECT_LE(narrow.use().used, narrow.use().low_water());
  EXPECT_FALSE(narrow.full());
}

TEST_F(DiskRoomTest, IsFullUntilItIsBelowTheHighWaterMark) {
  DiskRoom room = this->room(10 * kMegabyte);
  const auto fill = [&](std::uint64_t total) {
    const std::uint64_t other = used() - (std::filesystem::exists(stored_.folder.file("junk"))
                                              ? std::filesystem::file_size(stored_.folder.file("junk"))
                                              : 0);
    std::ofstream(stored_.folder.file("junk")) << std::string(total - other, 'x');
    EXPECT_TRUE(room.tidy().ok());
  };
  fill(95 * kMegabyte / 10);
  EXPECT_FALSE(room.full());
  fill(11 * kMegabyte);
  EXPECT_TRUE(room.full());
  fill(95 * kMegabyte / 10);
  EXPECT_TRUE(room.full());
  fill(8 * kMegabyte);
  EXPECT_FALSE(room.full());
}

TEST_F(DiskRoomTest, TellsOfAFolderThatIsOutOfReach) {
  DiskRoom room = this->room(10 * kMegabyte);
  EXPECT_TRUE(room.tidy().ok());
  const DiskUse before = room.use();
  const auto folder = stored_.folder.path() / "checkpoints", away = stored_.folder.path() / "away";
  std::filesystem::rename(folder, away);
  EXPECT_TRUE(is_disk_unreachable(room.tidy().error()));
  EXPECT_TRUE(is_disk_unreachable(room.found().error()));
  EXPECT_TRUE(is_disk_unreachable(room.make_room(1).error()));
  EXPECT_EQ(room.use().used, before.used);
  std::filesystem::rename(away, folder);
  EXPECT_TRUE(room.tidy().ok() && room.found().ok());
}

TEST(DiskSpace, TheReserveOfTheFileSystemIsNotUsed) {
  const TemporaryFolder folder;
  const auto all = measure_disk(folder.path(), {0, 0}), less = measure_disk(folder.path(), {0, 1ull << 60});
  ASSERT_TRUE(all.ok() && less.ok());
  EXPECT_GT(all->limit, 0u);
  EXPECT_EQ(less->limit, 0u) << "a reserve larger than the disk";
  EXPECT_EQ(measure_disk(folder.path(), {1000, 0})->limit, 1000u);
  EXPECT_FALSE(measure_disk(folder.path() / "nowhere", {}).ok());
}

class DiskFullTest : public ServiceTest {
 protected:
  void SetUp() override {
    ServiceOptions options;
    options.disk_quota_bytes = 64 * kMegabyte;
    start(options);
    scene_ = upload();
  }
  std::filesystem::path junk() const { return data_->path() / "data" / "junk"; }
  void fill() {
    std::ofstream(junk(), std::ios::binary) << "x";
    std::filesystem::resize_file(junk(), 100 * kMegabyte);  // sparse: counted, not written
  }
  bool becomes_ready(int status) {
    for (int i = 0; i < 500 && get(port_, "/readyz").status != status; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return get(port_, "/readyz").status == status;
  }

  std::string scene_;
};

TEST_F(DiskFullTest, JobsWaitWritesAreRefusedAndAllHealsByItself) {
  const std::string running = submit(scene_, R"("method":"path","film":{"width":100,"height":100},"stop":{"passes":2000})");
  const std::string asked = submit(scene_, R"("method":"path","stop":{"seconds":600})");
  wait_for_state(asked, "rendering");
  ASSERT_EQ(request(port_, "POST", "/v1/jobs/" + asked + "/pause").status, 202);
  const std::string endless = submit(scene_, R"("method":"path","stop":{"seconds":600})");
  wait_for_state(endless, "rendering");
  fill();
  ASSERT_TRUE(becomes_ready(503));
  EXPECT_EQ(wait_for_state(endless, "paused")["paused_because"], "disk_full");
  EXPECT_EQ(post_json(port_, "/v1/jobs", "{\"scene\":\"" + scene_ + "\"}").status, 507);
  const Reply refused = request(port_, "POST", "/v1/scenes", small_glb("other"), "model/gltf-binary");
  EXPECT_EQ(refused.status, 507);
  EXPECT_EQ(refused.headers.at("content-type"), "application/problem+json");
  EXPECT_NE(get(port_, "/metrics").body.find("photond_disk_full 1\n"), std::string::npos);
  EXPECT_EQ(get(port_, "/v1/jobs/" + endless).status, 200) << "reading goes on";
  EXPECT_EQ(get(port_, "/healthz").status, 200);
  std::filesystem::remove(junk());
  ASSERT_TRUE(becomes_ready(200));
  wait_for_state(endless, "rendering");
  EXPECT_EQ(job(asked)["state"], "paused") << "what was paused by request stays so";
  EXPECT_EQ(upload(small_glb("other")).size(), 64u);
  EXPECT_EQ(wait_for_end(running)["state"], "succeeded");
}

TEST_F(DiskFullTest, WhileTheDataDirectoryIsOutOfReachJobsWaitAndNothingIsLost) {
  const std::filesystem::path data = data_->path() / "data", away = data_->path() / "away";
  const std::string endless = submit(scene_, R"("method":"path","stop":{"seconds":600})");
  wait_for_state(endless, "rendering");
  std::filesystem::rename(data, away);
  std::filesystem::create_directory(data);  // as where a disk was mounted
  ASSERT_TRUE(becomes_ready(503));
  EXPECT_EQ(json::parse(get(port_, "/readyz").body)["code"], "disk_unreachable");
  EXPECT_EQ(wait_for_state(endless, "paused")["paused_because"], "disk_unreachable");
  const Reply refused = post_json(port_, "/v1/jobs", "{\"scene\":\"" + scene_ + "\"}");
  EXPECT_EQ(refused.status, 503);
  EXPECT_EQ(json::parse(refused.body)["code"], "io");
  EXPECT_EQ(get(port_, "/v1/scenes/" + scene_ + ".glb").status, 503) << "that it is gone cannot be told";
  EXPECT_NE(get(port_, "/metrics").body.find("photond_disk_unreachable 1\n"), std::string::npos);
  std::filesystem::remove_all(data);
  std::filesystem::rename(away, data);
  ASSERT_TRUE(becomes_ready(200));
  wait_for_state(endless, "rendering");
  EXPECT_EQ(get(port_, "/v1/scenes/" + scene_ + ".glb").status, 200);
}

TEST_F(DiskFullTest, AJobThatWasPausedMeanwhileIsPutAwayOnceThereIsRoom) {
  const auto kept = [this] { return !std::filesystem::is_empty(data_->path() / "data" / "frames"); };
  for (const bool stop : {false, true}) {
    const std::string id = submit(scene_, R"("method":"path","stop":{"seconds":600})");
    while (job(id)["passes"] == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    fill();
    ASSERT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/pause").status, 202);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    EXPECT_FALSE(kept());
    std::filesystem::remove(junk());
    if (stop) restart();  // no later than the disk is looked at
    for (int i = 0; i < 500 && !kept(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_TRUE(kept()) << stop;
    EXPECT_EQ(job(id)["paused_because"], "request");
    EXPECT_EQ(get(port_, "/v1/jobs/" + id + "/checkpoint").headers.at("photond-passes"), job(id)["passes"].dump());
    EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/cancel").status, 202);
    wait_for_end(id);
    ASSERT_EQ(request(port_, "DELETE", "/v1/jobs/" + id).status, 204);
  }
}

TEST_F(DiskFullTest, AFullDiskAtTheStartIsNoReasonNotToStart) {
  const std::string endless = submit(scene_, R"("method":"path","stop":{"seconds":600})");
  wait_for_state(endless, "rendering");
  service_.reset();
  fill();
  ServiceOptions options;
  options.disk_quota_bytes = 64 * kMegabyte;
  restart(options);
  EXPECT_EQ(wait_for_state(endless, "paused")["paused_because"], "disk_full");
  restart(options);
  EXPECT_EQ(job(endless)["paused_because"], "disk_full");
  std::filesystem::remove(junk());
  wait_for_state(endless, "rendering");
}

TEST_F(DiskFullTest, AJobWhoseCheckpointDoesNotFitWaitsForOthersOnly) {
  const std::string large = submit(
      scene_, R"("method":"path","film":{"width":1024,"height":1024},"stop":{"seconds":600})");
  const std::string other = submit(scene_, R"("method":"path","stop":{"seconds":600})");
  const json paused = wait_for_state(large, "paused");
  EXPECT_EQ(paused["paused_because"], "disk_full") << "its film alone has more than the quota";
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));  // the disk is looked after every second
  EXPECT_EQ(job(large)["state"], "paused");
  const Reply ready = get(port_, "/readyz");
  EXPECT_EQ(ready.status, 200);
  EXPECT_EQ(ready.body, "ready; jobs without room on the disk: 1\n");
  const std::string metrics = get(port_, "/metrics").body;
  EXPECT_NE(metrics.find("photond_disk_full 1\n"), std::string::npos);
  EXPECT_NE(metrics.find("photond_jobs_without_room 1\n"), std::string::npos);
  EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + other + "/cancel").status, 202);
  wait_for_state(large, "rendering");  // though it may lose its passes
  const std::string small = submit(scene_, R"("method":"path","stop":{"passes":3})");
  EXPECT_EQ(wait_for_end(small)["state"], "succeeded");
  EXPECT_EQ(get(port_, "/v1/jobs/" + small + "/frames/latest.png").status, 200) << "nothing goes in vain";
  EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + large + "/cancel").status, 202);
  EXPECT_EQ(wait_for_end(large)["state"], "canceled");
}

}  // namespace
}  // namespace photond::test
