// What is printed gets out, or the exit code says that it did not.
#include <gtest/gtest.h>

#include <cstdlib>

#include "core/film/encode.h"
#include "server/cli/files.h"
#include "tests/cli/program.h"

namespace photond::test {
namespace {

class StandardOutputTest : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string err_ = folder_.file("err");

  int run_on_full_disk(const std::vector<std::string>& arguments) {
    return wait_for_exit(spawn_photond(arguments, "/dev/full", err_));
  }
};

TEST_F(StandardOutputTest, WhatCannotBePrintedFailsEveryCommand) {
  const std::string scene = write_scene(folder_.path()), exr = folder_.file("a.exr"), data = folder_.file("data");
  const auto bytes = encode(Image(4, 4), ImageFormat::exr_float);
  ASSERT_TRUE(bytes.ok() && write_file(exr, *bytes).ok());
  ASSERT_EQ(run_photond({"key", "create", "--scope", "read", "--data", data}).code, 0);
  for (const auto& arguments : std::vector<std::vector<std::string>>{
           {"--version"}, {"info", scene}, {"info", "--json", scene}, {"compare", exr, exr}, {"key", "list", "--data", data}}) {
    EXPECT_EQ(run_on_full_disk(arguments), 1) << arguments[0];
    EXPECT_EQ(read_text(err_).find("photond: standard output: cannot be written"), 0u) << read_text(err_);
  }
}

TEST_F(StandardOutputTest, AKeyThatCannotBePrintedIsNotStored) {
  const std::string data = folder_.file("data");
  EXPECT_EQ(run_on_full_disk({"key", "create", "--scope", "read", "--data", data}), 1);
  EXPECT_EQ(read_text(err_), "photond: the key is not stored: standard output: cannot be written: No space left on device\n");
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "data" / "keys")) << "from which on a service would ask for keys";
}

TEST_F(StandardOutputTest, NoFileTakesThePlaceOfAClosedStream) {
  const std::string data = folder_.file("data");
  const std::string line = "'" PHOTOND_PROGRAM "' key create --scope read --data '" + data + "' >&- 2>'" + err_ + "'";
  EXPECT_NE(std::system(line.c_str()), 0);
  EXPECT_NE(read_text(err_).find("standard output: cannot be written"), std::string::npos) << read_text(err_);
  EXPECT_EQ(read_text(folder_.path() / "data" / "keys.lock"), "") << "the key was written into it";
}

}  // namespace
}  // namespace photond::test
