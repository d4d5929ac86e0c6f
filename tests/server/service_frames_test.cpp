#include <algorithm>
#include <filesystem>

#include "core/film/encode.h"
#include "server/jobs/frames.h"
#include "server/store/job_files.h"
#include "server/store/schema.h"
#include "tests/server/service_fixture.h"

namespace photond::test {
namespace {

using nlohmann::json;

class FramesTest : public ServiceTest {
 protected:
  static std::vector<Rgb> pixels(const std::string& exr, const std::string& layer = {}) {
    const auto image = decode_exr(std::as_bytes(std::span(exr.data(), exr.size())), layer);
    EXPECT_TRUE(image.ok()) << image.error().message;
    return image ? image->pixels : std::vector<Rgb>();
  }
};

TEST_F(FramesTest, AResultsErrorIsAPictureOfItsOwn) {
  const json done = wait_for_end(submit(upload(), R"("method":"path","stop":{"passes":9})"));
  const std::string frame = done["urls"]["frame"];
  const std::string whole = get(port_, frame + ".exr").body;
  for (const std::string layer : {"error.noise", "error.bias", "error.bound"}) {
    const Reply exr = get(port_, frame + ".exr?layer=" + layer);
    ASSERT_EQ(exr.status, 200) << exr.body;
    EXPECT_EQ(exr.headers.at("content-type"), "image/x-exr");
    EXPECT_EQ(pixels(exr.body), pixels(whole, layer));
    const Reply png = get(port_, frame + ".png?layer=" + layer);
    EXPECT_EQ(png.body.substr(1, 3), "PNG");
    EXPECT_EQ(get(port_, frame + ".jpg?layer=" + layer).body.substr(0, 2), "\xff\xd8");
    const Reply latest = get(port_, done["urls"]["latest"].get<std::string>() + ".png?layer=" + layer);
    EXPECT_EQ(latest.body, png.body);
    EXPECT_EQ(latest.headers.at("etag"), png.headers.at("etag"));
    EXPECT_EQ(latest.headers.at("content-location"), frame + ".png?layer=" + layer);
  }
  const Reply noise = get(port_, frame + ".png?layer=error.noise");
  EXPECT_NE(noise.body, get(port_, frame + ".png").body);
  EXPECT_NE(noise.headers.at("etag"), get(port_, frame + ".png").headers.at("etag"));
  EXPECT_NE(noise.headers.at("etag"), get(port_, frame + ".png?layer=error.bias").headers.at("etag"));
  const std::string known = noise.headers.at("etag");
  EXPECT_EQ(get(port_, frame + ".png?layer=error.noise", {{"If-None-Match", known}}).status, 304);
  EXPECT_EQ(get(port_, frame + ".png?layer=error", {}).status, 400);
}

TEST_F(FramesTest, ARunningJobsPicturesComeWithTheirErrorOnceSomebodyAsks) {
  const std::string id = submit(upload(), R"("method":"path","stop":{"seconds":60})");
  const std::string frames = "/v1/jobs/" + id + "/frames/";
  const Reply before = get(port_, frames + "latest.jpg?wait=20");
  ASSERT_EQ(before.status, 200);
  const Reply missing = get(port_, frames + before.headers.at("photond-revision") + ".png?layer=error.noise");
  EXPECT_EQ(missing.status, 404) << "it was not kept: nobody had asked";

  const Reply noise = get(port_, frames + "latest.exr?layer=error.noise&wait=20");
  ASSERT_EQ(noise.status, 200);
  float brightest = 0;
  for (const Rgb& pixel : pixels(noise.body)) brightest = std::max(brightest, pixel.r);
  EXPECT_GT(brightest, 0) << "it is noisy";
  EXPECT_GT(std::stoi(noise.headers.at("photond-revision")), std::stoi(before.headers.at("photond-revision")));
  const Reply next = get(port_, frames + "latest.jpg?layer=error.bound&wait=20&after=" +
                                    noise.headers.at("photond-revision"));
  EXPECT_EQ(next.status, 200);

  EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/pause").status, 202);
  // The last picture before the rest may come between two requests.
  Reply bound, whole;
  for (int i = 0; i < 500; ++i) {
    bound = get(port_, frames + "latest.exr?layer=error.bound");
    whole = get(port_, frames + "latest.exr");
    ASSERT_EQ(bound.status, 200);
    if (bound.headers["photond-revision"] == whole.headers["photond-revision"]) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(pixels(bound.body) == pixels(whole.body, "error.bound"));
  EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/cancel").status, 202);
}

TEST_F(FramesTest, APausedJobWhoseErrorNobodyHasAskedForHasNone) {
  const std::string id = submit(upload(), R"("method":"path","stop":{"passes":1000000})");
  const std::string frames = "/v1/jobs/" + id + "/frames/latest";
  ASSERT_EQ(get(port_, frames + ".jpg?wait=20").status, 200);
  ASSERT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/pause").status, 202);
  while (json::parse(get(port_, "/v1/jobs/" + id).body)["state"] != "paused") {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const Reply error = get(port_, frames + ".png?layer=error.bound");
  EXPECT_EQ(error.status, 404) << error.body;
  EXPECT_NE(error.body.find("detail"), std::string::npos) << error.body;
}

class CanceledPictureTest : public FramesTest {
 protected:
  std::string start_job() {
    return submit(upload(), R"("method":"path","film":{"width":320,"height":240},"stop":{"seconds":600})");
  }
  void cancel(const std::string& id) {
    EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/cancel").status, 202);
    wait_for_end(id);
  }
  std::size_t kept_files() const {
    const std::filesystem::path folder = data_->path() / "data" / "frames";
    const auto files = std::filesystem::recursive_directory_iterator(folder);
    return static_cast<std::size_t>(
        std::count_if(begin(files), end(files), [](const auto& entry) { return entry.is_regular_file(); }));
  }
};

TEST_F(CanceledPictureTest, IsNotKeptWhereNobodyHasAskedForOne) {
  const std::string id = start_job();
  while (job(id)["revision"] == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  cancel(id);
  restart();  // after which everything is as it was left
  EXPECT_EQ(kept_files(), 0u);
  EXPECT_EQ(get(port_, "/v1/jobs/" + id + "/frames/latest.png").status, 404);
}

TEST_F(CanceledPictureTest, IsThereInEveryFormatWhereSomebodyHas) {
  const std::string id = start_job();
  const std::string latest = "/v1/jobs/" + id + "/frames/latest.";
  const Reply seen = get(port_, latest + "jpg?wait=20");
  ASSERT_EQ(seen.status, 200);
  cancel(id);
  restart();
  EXPECT_GE(kept_files(), 1u);
  const Reply jpg = get(port_, latest + "jpg");
  ASSERT_EQ(jpg.status, 200);
  if (jpg.headers.at("etag") == seen.headers.at("etag")) {
    EXPECT_EQ(jpg.body, seen.body);
  }
  const Reply png = get(port_, latest + "png");
  EXPECT_EQ(png.body.substr(1, 3), "PNG");
  const Reply error = get(port_, latest + "png?layer=error.noise");
  EXPECT_EQ(error.status, 404);
  EXPECT_NE(error.body.find("was kept without its error"), std::string::npos) << error.body;
  EXPECT_EQ(get(port_, latest + "png").body, png.body) << "a revision's bytes never change";
  EXPECT_EQ(pixels(get(port_, latest + "exr").body).size(), 320u * 240u);
}

TEST(FramesOfARunningJob, ARevisionThatComesAgainTakesThePlaceOfTheFirst) {
  Frames frames;
  const auto grey = [](float value) {
    Image image(1, 1);
    image.pixels = {Rgb(value)};
    return image;
  };
  frames.publish(1, grey(0.1f), std::nullopt);
  frames.publish(2, grey(0.2f), std::nullopt);
  frames.publish(2, grey(0.8f), std::nullopt);
  const auto second = frames.get(2, FrameFormat::exr);
  ASSERT_TRUE(second.ok());
  EXPECT_NEAR(decode_exr(**second)->pixels[0].r, 0.8f, 1e-3f) << "of the passes that its record tells of";
  EXPECT_TRUE(frames.get(1, FrameFormat::exr).ok());
}

TEST_F(FramesTest, APictureThatNeverWasHasNotStayedTheSame) {
  const std::string id = submit(upload(), R"("method":"path","stop":{"passes":2})");
  const json done = wait_for_end(id);
  const Fields any{{"If-None-Match", "*"}};
  const std::string frames = "/v1/jobs/" + id + "/frames/";
  EXPECT_EQ(get(port_, frames + "999.png", any).status, 404);
  EXPECT_EQ(get(port_, frames + "999.png", {{"If-None-Match", "\"" + id + ".999.png\""}}).status, 404);
  EXPECT_EQ(get(port_, done["urls"]["frame"].get<std::string>() + ".png", any).status, 304);
  EXPECT_EQ(get(port_, frames + "latest.png", any).status, 304);
}

TEST_F(FramesTest, ASlowReaderOfAnEndedJobsPictureCostsLittleMemory) {
  constexpr std::int64_t kFileBytes = 40 << 20, kReaders = 8;
  const std::string id = submit(upload(), R"("method":"path","stop":{"passes":1})");
  const auto revision = wait_for_end(id)["revision"].get<std::uint32_t>();
  service_.reset();
  {
    const std::filesystem::path data = data_->file("data");
    auto database = Database::open(data / "photond.db", schema());
    ASSERT_TRUE(database.ok());
    auto files = JobFiles::open(**database, data / "frames", data / "checkpoints");
    ASSERT_TRUE(files.ok());
    const std::vector<std::byte> large(kFileBytes, std::byte{'x'});
    ASSERT_TRUE((*files)->drop_frames(id).ok() && (*files)->put_frame(id, revision, FrameFormat::exr, large).ok());
  }
  restart();
  const std::string target = "/v1/jobs/" + id + "/frames/latest.exr";
  EXPECT_LT(memory_of_slow_readers(target, kReaders), kReaders * kFileBytes / 4);
}

TEST_F(FramesTest, WhatIsKnownAlreadyIsToldWithTheHeadersOfTheWhole) {
  const std::string scene = upload();
  const json urls = wait_for_end(submit(scene, R"("method":"path","stop":{"passes":2})"))["urls"];
  const std::string frame = urls["frame"], latest = urls["latest"], scene_path = "/v1/scenes/" + scene;
  for (const std::string& target : {urls["self"].get<std::string>(), frame + ".png", latest + ".png",
                                    latest + ".exr?layer=error.bias", scene_path, scene_path + ".glb"}) {
    Reply whole = get(port_, target);
    Reply known = get(port_, target, {{"If-None-Match", whole.headers["etag"]}});
    EXPECT_EQ(known.status, 304) << target;
    EXPECT_NE(whole.headers["cache-control"], "") << target;
    for (const char* name : {"etag", "cache-control", "content-location", "photond-revision"}) {
      EXPECT_EQ(known.headers[name], whole.headers[name]) << target << ": " << name;
    }
  }
}

TEST_F(FramesTest, AfterARestartOneWaitsForThePictureAsBefore) {
  const std::string id = submit(upload(), R"("method":"path","film":{"width":800,"height":600},"stop":{"seconds":600})");
  const std::string latest = "/v1/jobs/" + id + "/frames/latest.jpg?wait=20";
  ASSERT_EQ(get(port_, latest).status, 200);
  restart();
  EXPECT_EQ(get(port_, latest).status, 200);
  EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/cancel").status, 202);
}

TEST(FramesOfAnEndedJob, ChangeNoBytesThatSomebodyHas) {
  Frames frames;
  frames.publish(1, Image(64, 64), std::nullopt);
  const auto jpg = frames.get(1, FrameFormat::jpg);
  const auto quick = frames.quick_exr(1);
  ASSERT_TRUE(jpg && quick);
  EXPECT_EQ(*frames.get(1, FrameFormat::exr), *quick) << "one EXR, whoever asks first";
  EXPECT_EQ(frames.close(1, FrameFormat::jpg), *jpg);
  EXPECT_EQ(*frames.get(1, FrameFormat::jpg), *jpg);
  EXPECT_EQ(frames.close(1, FrameFormat::png), nullptr);
  const auto png = frames.get(1, FrameFormat::png);
  ASSERT_FALSE(png) << "it would differ from what is made of the EXR later";
  EXPECT_EQ(png.error().code, ErrorCode::not_found);
}

TEST(FramesLayers, ShowAnErrorThreeStopsBrighter) {
  Frames frames;
  Image grey(2, 1);
  grey.pixels = {Rgb(0.5f), Rgb(0.25f)};
  Image faint(2, 1);
  faint.pixels = {Rgb(0.5f / 8), Rgb(0.25f / 8)};
  frames.publish(1, grey, std::nullopt);
  frames.publish(2, grey, ErrorLayers{faint, Image(2, 1), Image(2, 1)});
  EXPECT_EQ(frames.get(1, FrameFormat::png, FrameLayer::noise).error().code, ErrorCode::not_found);
  EXPECT_EQ(**frames.get(2, FrameFormat::png, FrameLayer::noise), **frames.get(1, FrameFormat::png));
  const auto exr = frames.get(2, FrameFormat::exr);
  ASSERT_TRUE(exr.ok());
  const auto from_file = picture_from_exr(**exr, FrameLayer::noise, FrameFormat::png);
  ASSERT_TRUE(from_file.ok());
  EXPECT_EQ(**from_file, **frames.get(2, FrameFormat::png, FrameLayer::noise)) << "a revision's bytes never change";
  EXPECT_EQ(picture_from_exr(**frames.get(1, FrameFormat::exr), FrameLayer::bound, FrameFormat::png).error().code,
            ErrorCode::not_found);
}

}  // namespace
}  // namespace photond::test
