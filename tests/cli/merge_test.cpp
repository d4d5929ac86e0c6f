#include <gtest/gtest.h>

#include <OpenImageIO/imageio.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "core/base/digest.h"
#include "server/store/accumulator.h"
#include "server/cli/picture.h"
#include "tests/cli/program.h"

namespace photond::test {
namespace {

class MergeCommandTest : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string scene_ = write_scene(folder_.path());
  std::string out_ = folder_.file("merged.exr");

  /// Renders these passes of a small picture and returns the accumulator file.
  std::string task(const std::string& passes, const std::string& photons = "2000", const std::string& method = "progressive",
                   const std::vector<std::string>& more = {}) {
    const std::string file = folder_.file("part" + std::to_string(parts_++) + ".acc");
    std::vector<std::string> arguments = {"task",   scene_,  "--out",    file,   "--passes",  passes,
                                          "--size", "24x16", "--method", method, "--photons", photons};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome run = run_photond(arguments);
    EXPECT_EQ(run.code, 0) << run.err;
    return file;
  }

  Outcome merge(const std::vector<std::string>& files) {
    std::vector<std::string> arguments = {"merge", "-o", out_};
    arguments.insert(arguments.end(), files.begin(), files.end());
    return run_photond(arguments);
  }

  void expect_refused(const std::vector<std::string>& files, const std::string& file, const std::string& reason) {
    std::filesystem::remove(out_);
    const Outcome run = merge(files);
    EXPECT_EQ(run.code, 1) << run.err;
    EXPECT_NE(run.err.find(file), std::string::npos) << run.err;
    EXPECT_NE(run.err.find(reason), std::string::npos) << run.err;
    EXPECT_EQ(run.err.find('\n'), run.err.size() - 1) << "one line: " << run.err;
    EXPECT_FALSE(std::filesystem::exists(out_));
  }

 private:
  int parts_ = 0;
};

/// All channels of an EXR.
std::vector<float> all_channels(const std::string& file) {
  const auto input = OIIO::ImageInput::open(file);
  if (!input) return {};
  const OIIO::ImageSpec spec = input->spec();
  std::vector<float> values(static_cast<std::size_t>(spec.width) * spec.height * spec.nchannels);
  input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeFloat, values.data());
  return values;
}

TEST_F(MergeCommandTest, AnySplitGivesTheBitsOfOneRendering) {
  const std::string whole = folder_.file("whole.exr");
  const std::string report = folder_.file("report.json");
  const Outcome render = run_photond({"render", scene_, "-o", whole, "--passes", "70", "--size", "24x16", "--method",
                                      "progressive", "--photons", "2000", "--threads", "1", "--report", report});
  ASSERT_EQ(render.code, 0) << render.err;
  const std::vector<std::string> files = {task("48:53"), task("0:9"), task("53:70"), task("9:48", "2000", "progressive", {"--threads", "2"})};
  const std::string png = folder_.file("merged.png"), merged_report = folder_.file("merged.json");
  std::vector<std::string> arguments = {"merge", "-o", out_, "-o", png, "--report", merged_report};
  arguments.insert(arguments.end(), files.begin(), files.end());
  const Outcome run = run_photond(arguments);
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_NE(run.err.find("merged 70 passes, estimated relative error "), std::string::npos) << run.err;
  EXPECT_EQ(read_text(png).substr(1, 3), "PNG");
  const std::vector<float> merged = all_channels(out_);
  EXPECT_EQ(merged.size(), 24u * 16 * 12);
  EXPECT_TRUE(merged == all_channels(whole)) << "picture and error layers";
  const auto one = nlohmann::json::parse(read_text(report)), joined = nlohmann::json::parse(read_text(merged_report));
  EXPECT_EQ(joined["passes"], 70);
  EXPECT_EQ(joined["error"], one["error"]);
  EXPECT_EQ(joined["scene"], one["scene"]["digest"]);
}

TEST_F(MergeCommandTest, RefusesOverlapsAndHoles) {
  const std::string a = task("0:4"), b = task("2:6"), c = task("5:6"), d = task("1:3");
  expect_refused({a, b}, b + ": contains passes 2:4, which " + a, "as well");
  expect_refused({a, a}, a, "0:4");
  expect_refused({a, c}, c, "the passes 4:5 are missing");
  expect_refused({d}, d, "the passes 0:1 are missing");
}

TEST_F(MergeCommandTest, RefusesPassesOfAnotherPicture) {
  const std::string a = task("0:1");
  const std::string seed = task("1:2", "2000", "progressive", {"--seed", "1"});
  expect_refused({a, seed}, seed, "settings.seed differs");
  expect_refused({a, task("1:2", "2001")}, "belongs to another picture", "settings.photons_per_pass");
  expect_refused({a, task("1:2", "2000", "path")}, "belongs to another picture", "settings.method");
  expect_refused({a, task("1:2", "2000", "progressive", {"--radius", "0.2"})}, "belongs to another picture", "settings.radius");
  std::string text = read_text(scene_);
  text.replace(text.find("0.7, 0.7, 0.7"), 13, "0.7, 0.7, 0.6");
  write_text(scene_, text);
  expect_refused({a, task("1:2")}, "belongs to another picture", "scene differs");
}

/// What a file with other bytes but a right length and checksum looks like.
std::string sealed(std::string text) {
  const std::uint64_t size = text.size();
  std::memcpy(&text[16], &size, sizeof size);
  const Digest digest = sha256(std::as_bytes(std::span(text).first(size - 32)));
  std::memcpy(&text[size - 32], digest.bytes.data(), 32);
  return text;
}

TEST_F(MergeCommandTest, RefusesDamagedAndHostileFiles) {
  const std::string a = task("0:1"), good = read_text(a), bad = folder_.file("bad.acc");
  const auto expect_bad = [&](const std::string& text, const std::string& reason) {
    const auto accumulator = read_accumulator(std::as_bytes(std::span(text)));
    ASSERT_FALSE(accumulator.ok()) << reason;
    EXPECT_EQ(accumulator.error().message.find(reason), 0u) << accumulator.error().message;
  };
  expect_bad("", "is not an accumulator file");
  expect_bad("photacc", "is not an accumulator file");
  expect_bad(std::string(100, 'x'), "is not an accumulator file");
  for (const std::size_t length : {8ul, 23ul, 24ul, 60ul, good.size() / 2, good.size() - 1})
    expect_bad(good.substr(0, length), "is truncated");
  expect_bad(good + "x", "is damaged");
  for (const std::size_t at : {30ul, 500ul, good.size() / 2, good.size() - 5}) {
    std::string flipped = good;
    flipped[at] = static_cast<char>(flipped[at] ^ 4);
    expect_bad(flipped, "is damaged: its checksum is wrong");
  }
  std::string version = good;
  version[8] = 9;
  expect_bad(version, "is an accumulator of version 9, not 2");

  write_text(bad, good.substr(0, good.size() / 2));
  expect_refused({a, bad}, bad, "is truncated");
  write_text(bad, "");
  expect_refused({bad}, bad, "is not an accumulator file");

  // With the right checksum: every number is still checked.
  std::string identity = good;
  std::memcpy(&identity[12], "\xff\xff\xff\xff", 4);
  expect_bad(sealed(identity), "is damaged: its identity is longer than allowed");
  std::string brace = good;
  brace[24] = '[';
  write_text(bad, sealed(brace));
  expect_refused({bad}, bad, "is damaged: its identity is not valid JSON");
  std::string build = good;
  const std::size_t hex = build.find("\"program\":\"") + 11;
  build[hex] = build[hex] == '0' ? '1' : '0';
  write_text(bad, sealed(build));
  expect_refused({a, bad}, bad, "build.program differs");
  std::uint32_t identity_bytes = 0;
  std::memcpy(&identity_bytes, &good[12], 4);
  const std::size_t film = 24 + identity_bytes;
  const auto with_word = [&](std::size_t word, std::uint32_t value) {
    std::string text = good;
    std::memcpy(&text[film + 4 * word], &value, 4);
    return sealed(text);
  };
  expect_bad(with_word(0, 0), "is damaged: the film has a size that is not allowed");
  expect_bad(with_word(0, 16384), "is damaged: the film has another length");
  expect_bad(with_word(1, 0xffffffff), "is damaged: the film has a size that is not allowed");
  expect_bad(with_word(2, 0xffffffff), "is damaged: the ranges of passes are not in order");
  expect_bad(with_word(3, 1), "is damaged: the ranges of passes are not in order");
  expect_bad(with_word(4, 20), "is damaged: the film has another length");
  expect_bad(sealed(good.substr(0, film) + std::string(32, 'x')), "is damaged");
  expect_bad(sealed(good.substr(0, 24) + std::string(32, 'x')), "is damaged");

  EXPECT_EQ(merge({folder_.file("nowhere.acc")}).code, 1);
  EXPECT_EQ(merge({folder_.path().string()}).code, 1);
  EXPECT_EQ(merge({a}).code, 0);
}

}  // namespace
}  // namespace photond::test
