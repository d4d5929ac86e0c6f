#include <gtest/gtest.h>

#include <array>

#include "tests/cli/program.h"

namespace photond::test {
namespace {

bool is_one_line(const std::string& text) { return !text.empty() && text.find('\n') == text.size() - 1; }

TEST(Usage, WrongCommandLinesExitWithTwoAndOneSentence) {
  const std::vector<std::vector<std::string>> wrong = {
      {},
      {"paint"},
      {"render"},
      {"render", "a.glb"},
      {"render", "a.glb", "-o", "a.gif"},
      {"render", "a.glb", "-o", "a.png", "--size", "12"},
      {"render", "a.glb", "-o", "a.png", "--size", "0x5"},
      {"render", "a.glb", "-o", "a.png", "--size", "64x64z"},
      {"render", "a.glb", "-o", "a.png", "--method", "magic"},
      {"render", "a.glb", "-o", "a.png", "--photons", "0"},
      {"render", "a.glb", "-o", "a.png", "--passes", "-3"},
      {"render", "a.glb", "-o", "a.png", "--passes", "0"},
      {"render", "a.glb", "-o", "a.png", "--error", "0"},
      {"render", "a.glb", "-o", "a.png", "--seconds", "nan"},
      {"render", "a.glb", "-o", "a.png", "--radius", "-1"},
      {"compare", "a.exr"},
      {"task", "a.glb", "--passes", "0:4"},
      {"task", "a.glb", "--out", "a.acc"},
      {"task", "a.glb", "--out", "a.acc", "--passes", "4"},
      {"task", "a.glb", "--out", "a.acc", "--passes", "4:4"},
      {"task", "a.glb", "--out", "a.acc", "--passes", "-1:4"},
      {"task", "a.glb", "--out", "a.acc", "--passes", "0:4294967296"},
      {"task", "a.glb", "--out", "a.acc", "--passes", "0:4", "--photons", "0"},
      {"merge", "a.acc"},
      {"merge", "-o", "a.exr"},
      {"merge", "a.acc", "-o", "a.acc"},
      {"info", "a.glb", "b.glb"},
      {"serve", "--port", "70000"},
      {"serve", "--map-cache-mb", "-1"},
  };
  for (const auto& arguments : wrong) {
    const Outcome run = run_photond(arguments);
    std::string line;
    for (const std::string& argument : arguments) line += " " + argument;
    EXPECT_EQ(run.code, 2) << line << "\n" << run.err;
    EXPECT_TRUE(is_one_line(run.err)) << line << "\n" << run.err;
    EXPECT_EQ(run.err.find("photond: "), 0u) << line << "\n" << run.err;
    EXPECT_EQ(run.out, "") << line;
  }
}

TEST(Usage, SettingsOutOfRangeNameTheOptionAndTheRange) {
  const std::string most = "18446744073709551615";
  const std::vector<std::array<std::string, 4>> wrong = {
      {"render", "--size", "0x5", "must be 1 to 16384"},
      {"render", "--error", "0", "must be a positive number"},
      {"render", "--error", "x", "expects a number"},
      {"render", "--radius", "nan", "must be a positive number of metres, or 0 for automatic"},
      {"render", "--radius", "1e39", "must be a positive number of metres, or 0 for automatic"},
      {"render", "--seconds", "inf", "must be a positive number"},
      {"render", "--passes", "0", "expects a whole number from 1 to 4294967295"},
      {"render", "--photons", "100000001", "expects a whole number from 1 to 100000000"},
      {"render", "--photons", "1e6", "expects a whole number from 1 to 100000000"},
      {"render", "--seed", "-1", "expects a whole number from 0 to " + most},
      {"render", "--seed", most + "0", "expects a whole number from 0 to " + most},
      {"render", "--threads", "1025", "expects a whole number from 0 to 1024"},
      {"serve", "--port", "65536", "expects a whole number from 0 to 65535"},
      {"serve", "--max-pixels", "0", "expects a whole number from 1 to 268435456"},
      {"serve", "--max-jobs", "-5", "expects a whole number from 1 to 1000000"},
      {"serve", "--max-streams", "0", "expects a whole number from 1 to 10000"},
      {"serve", "--drain-seconds", "nan", "expects a number from 0 to 3600"},
      {"serve", "--log-level", "loud", "expects debug, info, warning, error or off"},
  };
  for (const auto& [command, option, value, words] : wrong) {
    std::vector<std::string> arguments = {command, option, value};
    if (command == "render") arguments.insert(arguments.begin() + 1, {"a.glb", "-o", "a.png"});
    const Outcome run = run_photond(arguments);
    EXPECT_EQ(run.code, 2) << option << " " << value;
    EXPECT_EQ(run.err.find("photond: " + option + ": " + words), 0u) << option << " " << value << "\n" << run.err;
  }
  EXPECT_NE(run_photond({"key", "create", "--scope", "read", "--max-jobs", "-1"}).err.find("--max-jobs"), std::string::npos);
  EXPECT_NE(run_photond({"paint"}).err.find("paint"), std::string::npos);
  EXPECT_NE(run_photond({"key", "create"}).err.find("(see photond key create --help)"), std::string::npos);
  EXPECT_NE(run_photond({"--paint"}).err.find("(see photond --help)"), std::string::npos);
}

TEST(Usage, HelpAndVersionSucceed) {
  const Outcome help = run_photond({"--help"});
  EXPECT_EQ(help.code, 0);
  for (const char* command : {"serve", "render", "task", "merge", "info", "compare"}) {
    EXPECT_NE(help.out.find(command), std::string::npos);
    EXPECT_EQ(run_photond({command, "--help"}).code, 0);
  }
  EXPECT_EQ(run_photond({"--version"}).out, "photond " PHOTOND_VERSION "\n");
}

TEST(Usage, NothingThatIsReadOrWrittenIsOverwritten) {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder.path());
  const std::string before = read_text(scene), acc = folder.file("a.acc"), exr = folder.file("a.exr");
  write_text(acc, "passes");
  const std::string other = (folder.path() / "." / "a.exr").string();
  for (const auto& arguments : std::vector<std::vector<std::string>>{
           {"task", scene, "--passes", "0:1", "--size", "8x8", "--out", scene},
           {"render", scene, "--passes", "1", "--size", "8x8", "-o", exr, "--report", scene},
           {"render", scene, "--passes", "1", "--size", "8x8", "-o", exr, "--report", other},
           {"render", scene, "--passes", "1", "--size", "8x8", "-o", exr, "-o", other},
           {"merge", acc, "-o", exr, "--report", acc},
       }) {
    const Outcome run = run_photond(arguments);
    EXPECT_EQ(run.code, 2) << run.err;
    EXPECT_TRUE(is_one_line(run.err)) << run.err;
    EXPECT_NE(run.err.find("written"), std::string::npos) << run.err;
  }
  EXPECT_EQ(read_text(scene), before);
  EXPECT_EQ(read_text(acc), "passes");
}

// The permissions of root allow it: only trying tells.
TEST(Usage, WhereNothingCanBeWrittenIsToldBeforeTheWork) {
  const TemporaryFolder folder;
  const std::string missing = folder.file("missing.glb");
  EXPECT_NE(run_photond({"render", missing, "-o", "/proc/a.exr"}).err.find("/proc/a.exr: cannot be written"), std::string::npos);
  const std::string exr = folder.file("a.exr");
  EXPECT_NE(run_photond({"render", missing, "-o", exr}).err.find("missing.glb"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "trying leaves nothing behind";
}

TEST(Usage, WhatDoesNotExistExitsWithOneAndItsName) {
  const TemporaryFolder folder;
  const std::string missing = folder.file("missing.glb");
  for (const auto& arguments : std::vector<std::vector<std::string>>{
           {"info", missing},
           {"render", missing, "-o", folder.file("a.png")},
           {"compare", missing, missing},
           {"info", folder.path().string()},
           {"render", write_scene(folder.path()), "-o", folder.file("nowhere/a.png")},
           {"serve", "--port", "0", "--data", folder.file("data"), "--samples", folder.file("nowhere")},
           {"key", "list", "--data", folder.file("nowhere")},
       }) {
    const Outcome run = run_photond(arguments);
    EXPECT_EQ(run.code, 1) << run.err;
    EXPECT_TRUE(is_one_line(run.err)) << run.err;
    EXPECT_NE(run.err.find(folder.path().string()), std::string::npos) << run.err;
  }
  EXPECT_FALSE(std::filesystem::exists(folder.file("data"))) << "trying leaves nothing behind";
}

}  // namespace
}  // namespace photond::test
