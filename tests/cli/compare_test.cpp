#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/film/encode.h"
#include "tests/cli/program.h"

namespace photond::test {
namespace {

void write_constant(const std::string& file, int width, int height, const Rgb& value) {
  Image image(width, height);
  for (Rgb& pixel : image.pixels) pixel = value;
  const auto bytes = encode(image, ImageFormat::exr_float);
  ASSERT_TRUE(bytes.ok()) << bytes.error().message;
  write_text(file, std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()));
}

TEST(CompareCommandTest, MeasuresAKnownDifference) {
  const TemporaryFolder folder;
  const std::string a = folder.file("a.exr");
  const std::string reference = folder.file("r.exr");
  write_constant(reference, 32, 16, Rgb(1, 0.5f, 0.25f));
  write_constant(a, 32, 16, Rgb(1.25f, 0.5f, 0.25f));  // all exact in binary

  const Outcome run = run_photond({"compare", "--json", a, reference});
  ASSERT_EQ(run.code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_NEAR(json["mse"], 0.0625 / 3, 1e-12);             // .25² in one of three channels
  EXPECT_NEAR(json["rel_mse"], 0.0625 / 1.01 / 3, 1e-12);  // (a − r)²/(r² + .01)
  EXPECT_NEAR(json["rel_mse_trimmed"], 0.0625 / 1.01 / 3, 1e-12);
  EXPECT_EQ(json["mean_ratio"], (std::vector<double>{1.25, 1, 1}));
  const double block = 0.2126 * 0.25 / (0.2126 + 0.7152 * 0.5 + 0.0722 * 0.25);
  EXPECT_NEAR(json["max_block_deviation"], block, 1e-6);
  EXPECT_NEAR(json["median_block_deviation"], block, 1e-6);

  const Outcome text = run_photond({"compare", a, reference});
  EXPECT_EQ(text.code, 0);
  EXPECT_NE(text.out.find("1.250000 1.000000 1.000000"), std::string::npos) << text.out;
}

TEST(CompareCommandTest, RefusesWhatCannotBeCompared) {
  const TemporaryFolder folder;
  const std::string small = folder.file("small.exr");
  const std::string large = folder.file("large.exr");
  const std::string broken = folder.file("broken.exr");
  write_constant(small, 8, 8, Rgb(1));
  write_constant(large, 16, 8, Rgb(1));
  write_text(broken, read_text(large).substr(0, 300));
  EXPECT_EQ(run_photond({"compare", small, large}).code, 1);
  const Outcome run = run_photond({"compare", large, broken});
  EXPECT_EQ(run.code, 1);
  EXPECT_NE(run.err.find("broken.exr"), std::string::npos) << run.err;
}

}  // namespace
}  // namespace photond::test
