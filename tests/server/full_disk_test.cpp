// A file system that is really full: a small one in memory, which only root may mount.
#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <functional>

#include "server/store/database.h"
#include "server/store/file.h"
#include "tests/server/service_fixture.h"

namespace photond::test {
namespace {

using nlohmann::json;

/// A file system of its own, seen by this process only and gone with it.
class SmallDisk {
 public:
  /// Empty where it is mounted; else why not.
  std::string mount(const char* size) {
    if (::unshare(CLONE_NEWNS) != 0) return std::string("no mounts of its own: ") + std::strerror(errno);
    if (::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return std::strerror(errno);
    const std::string options = std::string("size=") + size;
    if (::mount("tmpfs", folder_.path().c_str(), "tmpfs", 0, options.c_str()) != 0) return std::strerror(errno);
    mounted_ = true;
    return {};
  }
  ~SmallDisk() {
    if (mounted_) ::umount2(folder_.path().c_str(), MNT_DETACH);
  }

  std::string file(const std::string& name) const { return folder_.file(name); }

  /// Takes what is left of it.
  void fill() {
    const int junk = ::open(file("junk").c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    ASSERT_GE(junk, 0);
    const std::string page(4096, 'x');
    while (::write(junk, page.data(), page.size()) > 0) {
    }
    EXPECT_EQ(errno, ENOSPC);
    ::close(junk);
  }
  void free() { std::filesystem::remove(file("junk")); }

 private:
  const TemporaryFolder folder_;
  bool mounted_ = false;
};

TEST(FullDisk, AWriteAheadLogThatCannotGrowLosesNothing) {
  SmallDisk disk;
  if (const std::string refused = disk.mount("2m"); !refused.empty()) GTEST_SKIP() << refused;
  const Migration tables[] = {{"CREATE TABLE rows (number INTEGER PRIMARY KEY, text TEXT NOT NULL)"}};
  auto database = Database::open(disk.file("db"), tables);
  ASSERT_TRUE(database.ok()) << database.error().message;
  const std::string text(5000, 't');
  const auto add = [&](std::uint64_t number) {
    return (*database)->write([&](Transaction& t) { return t.run("INSERT INTO rows VALUES (?, ?)", number, text); });
  };
  const auto count = [&] {
    std::uint64_t rows = 0;
    EXPECT_TRUE((*database)
                    ->read([&](Transaction& t) {
                      Query query = t.query("SELECT count(*) FROM rows");
                      if (query.next()) rows = query.whole(0);
                      return query.status();
                    })
                    .ok());
    return rows;
  };
  std::uint64_t written = 0;
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(add(++written).ok());
    disk.fill();
    Status last = Done{};
    while ((last = add(written + 1)).ok()) ++written;
    EXPECT_TRUE(is_disk_full(last.error())) << last.error().message;
    EXPECT_EQ(count(), written) << "what was acknowledged, and no more";
    EXPECT_FALSE(add(written + 1).ok()) << "still full";
    disk.free();
    ASSERT_TRUE(add(++written).ok()) << "the same connection goes on once there is room";
  }
  database->reset();
  database = Database::open(disk.file("db"), tables);
  ASSERT_TRUE(database.ok());
  EXPECT_EQ(count(), written);
}

class FullDiskTest : public ServiceTest {
 protected:
  void SetUp() override {
    if (const std::string refused = disk_.mount("48m"); !refused.empty()) GTEST_SKIP() << refused;
    options_.data_dir = disk_.file("data");
    options_.disk_quota_bytes = 0;    // what the file system has
    options_.disk_reserve_bytes = 0;  // so that it is full before the service sees it coming
    start(options_);
  }
  void TearDown() override { service_.reset(); }

  bool becomes_ready(int status, const std::function<void()>& meanwhile = [] {}) {
    for (int i = 0; i < 500 && get(port_, "/readyz").status != status; ++i) {
      meanwhile();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return get(port_, "/readyz").status == status;
  }
  std::string picture(const std::string& id) {
    EXPECT_EQ(wait_for_end(id)["state"], "succeeded");
    return get(port_, "/v1/jobs/" + id + "/frames/latest.exr").body;
  }

  SmallDisk disk_;
  ServiceOptions options_;
};

TEST_F(FullDiskTest, JobsPauseWritesAreRefusedAndAllHealsByItself) {
  const std::string scene = upload();
  const std::string spec = R"("method":"path","film":{"width":100,"height":100},"stop":{"passes":1500})";
  const std::string reference = submit(scene, spec);
  const std::string expected = picture(reference);
  ASSERT_EQ(request(port_, "DELETE", "/v1/jobs/" + reference).status, 204) << "what would be removed to make room";
  const std::string disturbed = submit(scene, spec);
  const std::string endless = submit(scene, R"("method":"path","stop":{"seconds":600})");
  wait_for_state(endless, "rendering");

  disk_.fill();
  // The log of the database may have room for a few more; whatever is acknowledged counts.
  std::vector<std::string> acknowledged{disturbed, endless};
  Reply last;
  for (int i = 0; i < 200 && last.status != 507; ++i) {
    last = post_json(port_, "/v1/jobs", "{\"scene\":\"" + scene + R"(","film":{"width":8,"height":8},"stop":{"passes":2}})");
    ASSERT_TRUE(last.status == 202 || last.status == 507) << last.status << last.body;
    if (last.status == 202) acknowledged.push_back(json::parse(last.body)["id"]);
  }
  EXPECT_EQ(last.status, 507);
  EXPECT_EQ(request(port_, "POST", "/v1/scenes", small_glb("other"), "model/gltf-binary").status, 507);
  ASSERT_TRUE(becomes_ready(503, [this] { disk_.fill(); })) << "though what cannot be written out leaves its place again";
  EXPECT_EQ(get(port_, "/healthz").status, 200);
  const auto passes = [&] { return job(endless)["passes"].get<int>(); };
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const int before = passes();
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_EQ(passes(), before) << "it waits";

  disk_.free();
  ASSERT_TRUE(becomes_ready(200));
  wait_for_state(endless, "rendering");
  EXPECT_EQ(picture(disturbed), expected) << "the same bits as without the full disk";
  for (const std::string& id : acknowledged) {
    if (id != endless) {
      EXPECT_EQ(wait_for_end(id)["state"], "succeeded");
    }
  }
  EXPECT_EQ(upload(small_glb("other")).size(), 64u);
  restart(options_);
  for (const std::string& id : acknowledged) EXPECT_EQ(get(port_, "/v1/jobs/" + id).status, 200) << id;
  EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + endless + "/cancel").status, 202);
}

}  // namespace
}  // namespace photond::test
