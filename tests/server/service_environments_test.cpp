#include "core/base/digest.h"
#include "core/film/encode.h"
#include "tests/server/service_fixture.h"

namespace photond::test {
namespace {

using nlohmann::json;

std::string exr(const Image& image) {
  const auto bytes = encode(image, ImageFormat::exr_float);
  EXPECT_TRUE(bytes.ok());
  return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()) : std::string();
}

// A sky of one radiance.
std::string even_sky(float radiance) {
  Image image(8, 4);
  for (Rgb& pixel : image.pixels) pixel = Rgb(radiance);
  return exr(image);
}

class EnvironmentsTest : public ServiceTest {
 protected:
  json add(const std::string& file, int status = 201) {
    const Reply reply = request(port_, "POST", "/v1/environments", file, "image/x-exr");
    EXPECT_EQ(reply.status, status) << reply.body;
    return json::parse(reply.body, nullptr, false);
  }
  json list() { return json::parse(get(port_, "/v1/environments").body)["environments"]; }

  // Mean radiance of a small picture of the scene in that environment.
  double brightness(const std::string& scene, const json& environment) {
    const std::string id = submit(scene, R"("method":"path","stop":{"passes":64},"environment":)" + environment.dump());
    const json done = wait_for_end(id);
    EXPECT_EQ(done["state"], "succeeded") << done;
    EXPECT_EQ(done["spec"]["environment"].is_null(), environment.is_null());
    const Reply frame = get(port_, "/v1/jobs/" + id + "/frames/latest.exr");
    const Reply picture = frame.status == 307 || frame.status == 302 ? get(port_, frame.headers.at("location")) : frame;
    const auto image = decode_exr(std::as_bytes(std::span(picture.body)));
    EXPECT_TRUE(image.ok());
    double sum = 0;
    if (image) {
      for (const Rgb& pixel : image->pixels) sum += static_cast<double>(luminance(pixel));
    }
    return sum;
  }
};

TEST_F(EnvironmentsTest, AreNamedByTheirContentAndKept) {
  const std::string file = even_sky(1);
  const json added = add(file);
  EXPECT_EQ(added["id"], to_hex(sha256(std::as_bytes(std::span(file)))));
  EXPECT_EQ(added["media_type"], "image/x-exr");
  EXPECT_EQ(added["width"], 8);
  EXPECT_EQ(added["height"], 4);
  EXPECT_EQ(add(file, 200), added);
  EXPECT_EQ(list(), json::array({added}));
  restart();
  EXPECT_EQ(list(), json::array({added}));
  const std::string self = "/v1/environments/" + added["id"].get<std::string>();
  EXPECT_EQ(json::parse(get(port_, self).body), added);
  EXPECT_EQ(request(port_, "POST", "/v1/environments", file, "image/x-exr").headers.at("location"), self);
  EXPECT_EQ(request(port_, "DELETE", self).status, 204);
  EXPECT_EQ(get(port_, self).status, 404);
  EXPECT_EQ(request(port_, "DELETE", self).status, 404);
  EXPECT_TRUE(list().empty());
}

TEST_F(EnvironmentsTest, KeepTheFirstNameTheyGet) {
  const std::string sky = even_sky(1);
  const auto name_after = [&](const std::string& query) {
    return json::parse(request(port_, "POST", "/v1/environments" + query, sky, "image/x-exr").body)["name"];
  };
  EXPECT_EQ(name_after(""), "");
  EXPECT_EQ(name_after("?name=dusk.exr"), "dusk.exr");
  EXPECT_EQ(name_after("?name=dawn.exr"), "dusk.exr");
  restart();
  EXPECT_EQ(list()[0]["name"], "dusk.exr");
}

TEST_F(EnvironmentsTest, ReadsHdrWhateverTheTypeSays) {
  const std::string hdr = std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n") + "\x80\x80\x80\x81\x80\x80\x80\x81";
  const Reply reply = request(port_, "POST", "/v1/environments", hdr, "application/octet-stream");
  ASSERT_EQ(reply.status, 201) << reply.body;
  EXPECT_EQ(json::parse(reply.body)["media_type"], "image/vnd.radiance");
}

TEST_F(EnvironmentsTest, WarnsOfNegativeValuesAndRefusesWhatIsWrong) {
  Image image(2, 1);
  image.pixels = {{1, -1, 1}, {1, 1, 1}};
  EXPECT_NE(add(exr(image))["warnings"][0].get<std::string>().find("1 negative"), std::string::npos);
  image.pixels[0].y = std::numeric_limits<float>::infinity();
  const std::string file = exr(image);
  EXPECT_NE(add(file, 422)["detail"].get<std::string>().find("pixel (0, 0)"), std::string::npos);
  add(file.substr(0, file.size() / 2), 422);
  EXPECT_EQ(request(port_, "POST", "/v1/environments", "GIF89a", "image/x-exr").status, 422);
  EXPECT_EQ(request(port_, "POST", "/v1/environments", file, "image/png").status, 415);
  EXPECT_EQ(list().size(), 1u);
}

TEST_F(EnvironmentsTest, LightTheJobsThatAskForThem) {
  const std::string scene = upload();
  const std::string sky = add(even_sky(1))["id"];
  const double without = brightness(scene, nullptr);
  const double with = brightness(scene, {{"id", sky}}) - without;
  EXPECT_GT(with, 0);
  // Light adds up; the seeds are fixed, and what is left of the noise is below a tenth.
  EXPECT_NEAR(brightness(scene, {{"id", sky}, {"scale", 3}, {"rotation_deg", 90}}) - without, 3 * with, 0.3 * with);
}

TEST_F(EnvironmentsTest, AJobMustNameOneThatIsThere) {
  const std::string scene = upload();
  const std::string sky = add(even_sky(1))["id"];
  const auto post = [&](const std::string& environment) {
    return post_json(port_, "/v1/jobs", R"({"scene":")" + scene + R"(","environment":)" + environment + "}");
  };
  const Reply unknown = post(R"({"id":")" + std::string(64, '0') + R"("})");
  EXPECT_EQ(unknown.status, 422) << unknown.body;
  EXPECT_EQ(json::parse(unknown.body)["pointer"], "/environment/id");
  EXPECT_EQ(post(R"({"id":")" + sky + R"(","scale":-1})").status, 422);
  EXPECT_EQ(post(R"({"id":")" + sky + R"(","rotation_deg":400})").status, 422);
  EXPECT_EQ(post(R"({"rotation_deg":4})").status, 422);
}

TEST_F(EnvironmentsTest, OneThatALiveJobNeedsStays) {
  const std::string scene = upload();
  const std::string sky = add(even_sky(1))["id"];
  const std::string id = submit(scene, R"("stop":{"passes":1000000},"environment":{"id":")" + sky + R"("})");
  EXPECT_EQ(request(port_, "DELETE", "/v1/environments/" + sky).status, 409);
  EXPECT_EQ(request(port_, "POST", "/v1/jobs/" + id + "/cancel").status, 202);
  wait_for_end(id);
  EXPECT_EQ(request(port_, "DELETE", "/v1/environments/" + sky).status, 204);
}

TEST_F(EnvironmentsTest, AJobWhoseSkyIsGoneStaysAsItEnded) {
  const std::string sky = add(even_sky(1))["id"];
  const std::string id = submit(upload(), R"("stop":{"passes":2},"environment":{"id":")" + sky + R"("})");
  const json done = wait_for_end(id);
  EXPECT_EQ(request(port_, "DELETE", "/v1/environments/" + sky).status, 204);
  EXPECT_EQ(post_json(port_, "/v1/jobs/" + id + "/extend", R"({"stop":{"passes":4}})").status, 409);
  EXPECT_EQ(job(id), done);
}

}  // namespace
}  // namespace photond::test
