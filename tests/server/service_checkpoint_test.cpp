#include <thread>

#include "server/store/accumulator.h"
#include "tests/cli/program.h"
#include "tests/server/service_fixture.h"

namespace photond::test {
namespace {

using namespace std::chrono_literals;

/// The checkpoint of a job, once there is one.
Reply wait_for_checkpoint(int port, const std::string& id) {
  for (int i = 0; i < 600; ++i) {
    const Reply reply = get(port, "/v1/jobs/" + id + "/checkpoint");
    if (reply.status != 404) return reply;
    std::this_thread::sleep_for(50ms);
  }
  ADD_FAILURE() << "no checkpoint in half a minute";
  return {};
}

TEST_F(ServiceTest, ARunningJobsCheckpointIsAnAccumulator) {
  const std::string id = submit(upload(), R"("method":"path","stop":{"seconds":60})");
  const Reply reply = wait_for_checkpoint(port_, id);
  ASSERT_EQ(reply.status, 200) << reply.body;
  EXPECT_EQ(reply.headers.at("content-type"), "application/octet-stream");
  const auto accumulator = read_accumulator(std::as_bytes(std::span(reply.body)));
  ASSERT_TRUE(accumulator.ok()) << accumulator.error().message;
  EXPECT_EQ(std::to_string(accumulator->film.pass_count()), reply.headers.at("photond-passes"));
  EXPECT_EQ(accumulator->film.width, 16);
  EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/cancel").status, 202);
}

TEST_F(ServiceTest, ADownloadOfACheckpointGoesOnWhereItBroke) {
  const std::string id = submit(upload(), R"("method":"path","stop":{"seconds":2.5})");
  const int passes = wait_for_end(id)["passes"];
  const std::string target = "/v1/jobs/" + id + "/checkpoint";
  const Reply whole = wait_for_checkpoint(port_, id);
  ASSERT_EQ(whole.status, 200);
  EXPECT_EQ(whole.headers.at("photond-passes"), std::to_string(passes));
  const std::string etag = whole.headers.at("etag");
  const std::size_t half = whole.body.size() / 2;
  const Reply first = get(port_, target, {{"Range", "bytes=0-" + std::to_string(half - 1)}});
  const Reply second = get(port_, target, {{"Range", "bytes=" + std::to_string(half) + "-"}, {"If-Range", etag}});
  EXPECT_EQ(first.status, 206);
  EXPECT_EQ(second.status, 206);
  EXPECT_EQ(first.body.size(), half);
  EXPECT_EQ(first.headers.at("content-range"),
            "bytes 0-" + std::to_string(half - 1) + "/" + std::to_string(whole.body.size()));
  EXPECT_EQ(first.body + second.body, whole.body);
  EXPECT_EQ(get(port_, target, {{"Range", "bytes=99999999999-"}}).status, 416);
  EXPECT_EQ(get(port_, target, {{"Range", "bytes=0-1"}, {"If-Range", "\"other\""}}).body, whole.body);
  EXPECT_EQ(get(port_, target, {{"If-None-Match", etag}}).status, 304);

  // merge makes of it the picture of its passes.
  const TemporaryFolder folder;
  write_text(folder.file("job.acc"), whole.body);
  write_text(folder.file("scene.glb"), small_glb());
  const Outcome merged = run_photond({"merge", folder.file("job.acc"), "-o", folder.file("job.exr")});
  EXPECT_EQ(merged.code, 0) << merged.err;
  const Outcome rendered = run_photond({"render", folder.file("scene.glb"), "-o", folder.file("same.exr"), "--size", "16x12",
                                        "--method", "path", "--passes", whole.headers.at("photond-passes")});
  EXPECT_EQ(rendered.code, 0) << rendered.err;
  EXPECT_TRUE(read_text(folder.file("job.exr")) == read_text(folder.file("same.exr"))) << "the same bits";
}

TEST_F(ServiceTest, OnlyWhatHasACheckpointGivesOne) {
  const std::string id = submit(upload(), R"("method":"path","stop":{"passes":1})");
  wait_for_end(id);
  EXPECT_EQ(get(port_, "/v1/jobs/" + id + "/checkpoint").status, 404);
  EXPECT_EQ(get(port_, "/v1/jobs/none/checkpoint").status, 404);
}

TEST_F(ServiceTest, PicturesAreMadeWhileSomebodyLooks) {
  ServiceOptions options;
  options.watch_time = 100ms;
  start(options);
  const std::string scene = upload();
  const auto pictures = [this](const std::string& id) { return job(id)["revision"].get<int>(); };
  const std::string alone = submit(scene, R"("method":"path","stop":{"seconds":3})");
  std::this_thread::sleep_for(5s);
  ASSERT_EQ(job(alone)["state"], "succeeded");
  EXPECT_LE(pictures(alone), 2) << "one in the first 100 ms, and the result";
  const std::string watched = submit(scene, R"("method":"path","stop":{"seconds":3})");
  get(port_, "/v1/jobs/" + watched + "/events");
  EXPECT_GE(pictures(watched), 3) << "half a second apart, where passes allow";
  const std::string polled = submit(scene, R"("method":"path","stop":{"seconds":3})");
  int seen = 0;
  for (int i = 0; i < 100 && job(polled)["state"] != "succeeded"; ++i) {
    const Reply reply = get(port_, "/v1/jobs/" + polled + "/frames/latest.jpg?wait=1&after=" + std::to_string(seen));
    if (reply.status == 200) seen = std::stoi(reply.headers.at("photond-revision"));
  }
  EXPECT_GE(seen, 3);
}

}  // namespace
}  // namespace photond::test
