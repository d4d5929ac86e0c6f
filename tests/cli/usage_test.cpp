#include <gtest/gtest.h>

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

TEST(Usage, SettingsOutOfRangeNameTheOption) {
  EXPECT_NE(run_photond({"render", "a.glb", "-o", "a.png", "--size", "0x5"}).err.find("--size"),
            std::string::npos);
  EXPECT_NE(run_photond({"render", "a.glb", "-o", "a.png", "--error", "0"}).err.find("--error"),
            std::string::npos);
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
       }) {
    const Outcome run = run_photond(arguments);
    EXPECT_EQ(run.code, 1) << run.err;
    EXPECT_TRUE(is_one_line(run.err)) << run.err;
    EXPECT_NE(run.err.find(folder.path().string()), std::string::npos) << run.err;
  }
}

}  // namespace
}  // namespace photond::test
