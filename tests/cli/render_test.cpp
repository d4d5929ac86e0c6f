#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/film/encode.h"
#include "server/cli/picture.h"
#include "tests/cli/program.h"

namespace photond::test {
namespace {

class RenderCommandTest : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string scene_ = write_scene(folder_.path());
  std::string exr_ = folder_.file("out.exr");
  std::string report_ = folder_.file("report.json");

  nlohmann::json report() const { return nlohmann::json::parse(read_text(report_)); }
};

TEST_F(RenderCommandTest, WritesEveryFormatAndTheReport) {
  const std::string png = folder_.file("out.PNG");
  const std::string jpg = folder_.file("out.jpg");
  const Outcome run =
      run_photond({"render",    scene_,  "-o",       exr_, "-o",       png,     "-o",       jpg,
                   "--size",    "48x32", "--passes", "4",  "--camera", "above", "--method", "progressive",
                   "--photons", "5000",  "--seed",   "7",  "--report", report_});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(run.err.find("progressive: 4 passes in "), 0u) << run.err;
  EXPECT_EQ(run.err.find('\r'), std::string::npos) << "a progress bar where there is no terminal";

  const auto image = read_picture(exr_);
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ(image->width, 48);
  EXPECT_EQ(image->height, 32);
  double sum = 0;
  for (const Rgb& pixel : image->pixels) sum += luminance(pixel);
  EXPECT_GT(sum, 0);
  EXPECT_EQ(read_text(png).substr(1, 3), "PNG");
  EXPECT_EQ(read_text(jpg).substr(0, 2), "\xff\xd8");

  const nlohmann::json json = report();
  EXPECT_EQ(json["passes"], 4);
  EXPECT_EQ(json["stopped_by"], "passes");
  EXPECT_EQ(json["settings"]["method"], "progressive");
  EXPECT_EQ(json["settings"]["seed"], 7);
  EXPECT_EQ(json["scene"]["plan"]["method"], "progressive");
  EXPECT_EQ(json["scene"]["counts"]["triangles"], 4);
  EXPECT_EQ(json["series"].size(), 4u);
  EXPECT_EQ(json["series"].back()["passes"], 4);
  EXPECT_GT(json["error"]["relative"], 0);
  EXPECT_NEAR(std::hypot(json["error"]["noise"].get<double>(), json["error"]["bias"].get<double>()),
              json["error"]["relative"], 1e-12);
  EXPECT_EQ(json["error"]["few_passes"], true);
  EXPECT_EQ(json["rejected_samples"], 0);
  EXPECT_EQ(json["reference"], nullptr);
  EXPECT_GT(json["seconds"]["render"], 0);
  EXPECT_EQ(json["maps"]["built"], 4);
  EXPECT_EQ(json["maps"]["emitted_paths"], 4 * 5000);
  const auto& energy = json["maps"]["energy"];
  const double spent = energy["absorbed"].get<double>() + energy["escaped"].get<double>() +
                       energy["truncated"].get<double>() + energy["rejected"].get<double>();
  EXPECT_NEAR(spent / energy["emitted"].get<double>(), 1, 1e-6) << "the ledger must close";
}

TEST_F(RenderCommandTest, TheThreadCountDoesNotChangeABit) {
  const std::string other = folder_.file("other.exr");
  for (const char* method : {"path", "photon_map", "progressive", "hybrid"}) {
    const auto render = [&](const std::string& output, const std::string& threads) {
      return run_photond({"render", scene_, "-o", output, "--size", "40x40", "--passes", "2", "--method",
                          method, "--photons", "3000", "--threads", threads})
          .code;
    };
    ASSERT_EQ(render(exr_, "1"), 0);
    ASSERT_EQ(render(other, "4"), 0);
    const auto a = read_picture(exr_);
    const auto b = read_picture(other);
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_EQ(a->pixels, b->pixels) << method;
  }
}

// Whoever sees only the line, the report or a picture is told as well.
TEST_F(RenderCommandTest, ABiasedMethodIsLabelledEverywhere) {
  const std::string png = folder_.file("out.png"), jpg = folder_.file("out.jpg");
  for (const std::string method : {"photon_map", "progressive"}) {
    const bool biased = method == "photon_map";
    for (const std::string passes : {"1", "9"}) {   // without and with an estimated error
      const Outcome run = run_photond({"render", scene_, "-o", exr_, "-o", png, "-o", jpg, "--size", "16x16", "--passes",
                                       passes, "--photons", "3000", "--method", method, "--report", report_});
      ASSERT_EQ(run.code, 0) << run.err;
      EXPECT_EQ(run.err.find("bias") != std::string::npos && run.err.find("method") != std::string::npos, biased) << run.err;
      EXPECT_EQ(report()["scene"]["plan"]["biased"], biased);
      for (const std::string& file : {exr_, png, jpg}) {
        EXPECT_EQ(read_text(file).find("photond photon_map: biased") != std::string::npos, biased) << file;
      }
    }
  }
}

TEST_F(RenderCommandTest, TakesAsManyPhotonsAsThePictureNeeds) {
  const std::vector<std::string> base = {"render", scene_,  "-o", exr_,       "--method",
                                         "path",   "--passes", "1",  "--report", report_};
  for (const auto& [options, photons] : std::initializer_list<std::pair<std::vector<std::string>, int>>{
           {{"--size", "640x480"}, 524'288}, {{"--size", "32x32"}, 16'384}, {{"--photons", "100", "--size", "640x480"}, 100}}) {
    auto arguments = base;
    arguments.insert(arguments.end(), options.begin(), options.end());
    ASSERT_EQ(run_photond(arguments).code, 0);
    EXPECT_EQ(report()["settings"]["photons_per_pass"], photons);
  }
}

TEST_F(RenderCommandTest, StopsByTimeAndByError) {
  const std::vector<std::string> base = {"render", scene_,     "-o",   exr_,       "--size",
                                         "32x32",  "--method", "path", "--report", report_};
  auto timed = base;
  timed.insert(timed.end(), {"--seconds", "0.3"});
  ASSERT_EQ(run_photond(timed).code, 0);
  EXPECT_EQ(report()["stopped_by"], "seconds");
  EXPECT_GE(report()["seconds"]["render"], 0.3);

  auto exact = base;
  exact.insert(exact.end(), {"--error", "0.2", "--seconds", "60"});
  ASSERT_EQ(run_photond(exact).code, 0);
  EXPECT_EQ(report()["stopped_by"], "relative_error");
  EXPECT_LE(report()["error"]["relative"], 0.2);
}

TEST_F(RenderCommandTest, ReportsTheTrueErrorAgainstAReference) {
  const std::string reference = folder_.file("reference.exr");
  const auto render = [&](const std::string& output, const std::string& passes, std::vector<std::string> more) {
    std::vector<std::string> arguments = {"render", scene_,     "-o",   output,     "--method",
                                          "path",   "--passes", passes, "--report", report_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_photond(arguments);
  };
  ASSERT_EQ(render(reference, "400", {"--size", "24x24", "--seed", "1"}).code, 0);
  const Outcome run = render(exr_, "100", {"--size", "24x24", "--reference", reference});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_NE(run.err.find(", true relMSE "), std::string::npos) << run.err;
  const Outcome compared = run_photond({"compare", "--json", exr_, reference});
  ASSERT_EQ(compared.code, 0) << "compare must read pictures with error layers: " << compared.err;
  const double rel_mse = nlohmann::json::parse(compared.out)["rel_mse"];
  const nlohmann::json json = report();
  EXPECT_EQ(json["reference"]["rel_mse"], rel_mse);
  EXPECT_EQ(json["series"].back()["passes"], 100);
  EXPECT_EQ(json["series"].back()["rel_mse"], rel_mse);
  EXPECT_GT(json["series"][0]["rel_mse"], rel_mse);
  // Both pictures have noise: the reference a quarter of the variance. Within a factor of two, since a few pixels at the
  // lamp's edges hold most of it.
  const double estimated = 1.25 * std::pow(json["error"]["relative"].get<double>(), 2);
  EXPECT_GT(estimated, rel_mse / 2);
  EXPECT_LT(estimated, rel_mse * 2);

  const Outcome smaller = render(exr_, "2", {"--reference", reference, "--size", "20x24"});
  EXPECT_NE(smaller.code, 0);
  EXPECT_NE(render(exr_, "2", {"--reference", folder_.file("none.exr")}).err.find("none.exr"), std::string::npos);
}

TEST_F(RenderCommandTest, AnInterruptWritesWhatThereIs) {
  const Outcome run = run_photond({"render", scene_, "-o", exr_, "--size", "32x32", "--method", "path",
                                   "--seconds", "60", "--report", report_},
                                  2);
  EXPECT_EQ(run.code, 130) << run.err;
  EXPECT_TRUE(read_picture(exr_).ok());
  EXPECT_EQ(report()["stopped_by"], "interrupt");
  EXPECT_LT(report()["seconds"]["render"], 30);
}

TEST_F(RenderCommandTest, AnUnknownCameraIsRefusedWithTheKnownOnes) {
  const Outcome run = run_photond({"render", scene_, "-o", exr_, "--camera", "below"});
  EXPECT_EQ(run.code, 1);
  EXPECT_NE(run.err.find("'above'"), std::string::npos) << run.err;
  EXPECT_FALSE(std::filesystem::exists(exr_));
}

}  // namespace
}  // namespace photond::test
