#include <gmock/gmock.h>

#include <span>

#include "core/film/encode.h"
#include "server/cli/files.h"
#include "server/cli/picture.h"
#include "tests/cli/program.h"

namespace photond::test {
namespace {

using testing::HasSubstr;

class EnvironmentOption : public ::testing::Test {
 protected:
  // A sky whose half around +X shines.
  std::string sky() const {
    Image image(8, 4);
    for (int y = 0; y < 4; ++y) {
      for (int x = 2; x < 6; ++x) image.at(x, y) = Rgb(1);
    }
    const std::string file = folder_.file("sky.exr");
    EXPECT_TRUE(write_file(file, *encode(image, ImageFormat::exr_float)).ok());
    return file;
  }

  // Mean radiance of the white floor.
  double floor(const std::vector<std::string>& options) const {
    const std::string exr = folder_.file("out.exr");
    std::vector<std::string> arguments = {"render", scene_, "-o", exr, "--size", "16x16", "--passes", "64", "--method", "path"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Outcome run = run_photond(arguments);
    EXPECT_EQ(run.code, 0) << run.err;
    const auto picture = read_picture(exr);
    if (!picture) return 0;
    double sum = 0;
    for (const Rgb& pixel : picture->pixels) sum += static_cast<double>(luminance(pixel)) / 256;
    return sum;
  }

  TemporaryFolder folder_;
  std::string scene_ = write_scene(folder_.path());
};

TEST_F(EnvironmentOption, LightsTheScene) {
  const std::string file = sky();
  const double without = floor({});
  const double with = floor({"--environment", file}) - without;
  EXPECT_GT(with, 0.01);
  // Light adds up: noise of a hundredth in each.
  EXPECT_NEAR(floor({"--environment", file, "--environment-scale", "3"}) - without, 3 * with, 0.06 * with);
  EXPECT_NEAR(floor({"--environment", file, "--environment-scale", "0"}), without, 0.03 * with);
}

TEST_F(EnvironmentOption, IsPartOfTheScene) {
  const std::string file = sky();
  const Outcome info = run_photond({"info", scene_, "--environment", file, "--environment-rotation", "90"});
  EXPECT_EQ(info.code, 0) << info.err;
  EXPECT_THAT(info.out, HasSubstr("times a map of 8x4 pixels, turned by 90 degrees"));
  EXPECT_THAT(info.out, HasSubstr("+ environment: the scene is lit from around"));
  const auto task = [&](const std::string& passes, const std::string& rotation, const std::string& out) {
    const Outcome run = run_photond({"task", scene_, "--size", "8x8", "--passes", passes, "-o", folder_.file(out),
                                     "--environment", file, "--environment-rotation", rotation});
    EXPECT_EQ(run.code, 0) << run.err;
  };
  task("0:2", "10", "a.acc");
  task("2:3", "10", "b.acc");
  task("2:3", "11", "c.acc");
  const std::string exr = folder_.file("merged.exr");
  EXPECT_EQ(run_photond({"merge", folder_.file("a.acc"), folder_.file("b.acc"), "-o", exr}).code, 0);
  EXPECT_EQ(run_photond({"merge", folder_.file("a.acc"), folder_.file("c.acc"), "-o", exr}).code, 1);
}

TEST_F(EnvironmentOption, NamesWhatIsWrong) {
  const Outcome missing = run_photond({"info", scene_, "--environment", folder_.file("none.hdr")});
  EXPECT_EQ(missing.code, 1);
  EXPECT_THAT(missing.err, HasSubstr("none.hdr"));
  const Outcome other = run_photond({"info", scene_, "--environment", scene_});
  EXPECT_EQ(other.code, 1);
  EXPECT_THAT(other.err, HasSubstr("neither OpenEXR nor Radiance HDR"));
  EXPECT_EQ(run_photond({"info", scene_, "--environment-scale", "2"}).code, 2);
  EXPECT_EQ(run_photond({"info", scene_, "--environment", sky(), "--environment-scale", "-1"}).code, 2);
  EXPECT_EQ(run_photond({"info", scene_, "--environment", sky(), "--environment-rotation", "nan"}).code, 2);
}

}  // namespace
}  // namespace photond::test
