#include "server/store/data_directory.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "tests/support/temporary_folder.h"

namespace photond {
namespace {

TEST(DataDirectory, IsCreatedForItsOwnerOnly) {
  const test::TemporaryFolder folder;
  const std::string path = folder.file("a/b");
  const auto directory = DataDirectory::open(path);
  ASSERT_TRUE(directory.ok()) << directory.error().message;
  struct stat status {};
  ASSERT_EQ(::stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0700u);
  EXPECT_EQ(directory->database(), path + "/photond.db");
  EXPECT_EQ(directory->folder("maps"), path + "/maps");
}

TEST(DataDirectory, TheSecondUserIsToldOfTheFirst) {
  const test::TemporaryFolder folder;
  {
    const auto first = DataDirectory::open(folder.file("data"));
    ASSERT_TRUE(first.ok());
    const auto second = DataDirectory::open(folder.file("data"));
    ASSERT_FALSE(second.ok());
    EXPECT_EQ(second.error().code, ErrorCode::conflict);
    EXPECT_NE(second.error().message.find("process " + std::to_string(getpid())), std::string::npos)
        << second.error().message;
  }
  EXPECT_TRUE(DataDirectory::open(folder.file("data")).ok()) << "free again";
}

TEST(DataDirectory, WhatIsNoFolderIsAnError) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.file("file")) << "x";
  EXPECT_FALSE(DataDirectory::open(folder.file("file")).ok());
  EXPECT_FALSE(DataDirectory::open("").ok());
}

TEST(DataDirectory, WithoutItsDatabaseItsFilesAreKept) {
  const test::TemporaryFolder folder;
  const auto scene = folder.path() / "scenes" / std::string(64, 'a');
  std::filesystem::create_directories(scene.parent_path());
  std::ofstream(folder.file("scenes/other")) << "x";
  EXPECT_TRUE(DataDirectory::open(folder.path().string()).ok());
  std::ofstream(scene) << "x";
  for (const bool empty : {false, true}) {
    if (empty) std::ofstream(folder.file("photond.db")).flush();
    const auto refused = DataDirectory::open(folder.path().string());
    ASSERT_FALSE(refused.ok()) << empty;
    EXPECT_NE(refused.error().message.find("is missing or empty"), std::string::npos) << refused.error().message;
  }
  std::ofstream(folder.file("photond.db")) << "SQLite";
  EXPECT_TRUE(DataDirectory::open(folder.path().string()).ok()) << "whether it is whole others say";
}

TEST(DataDirectory, TheDefaultFollowsXdg) {
  const char* data = std::getenv("XDG_DATA_HOME");
  const char* home = std::getenv("HOME");
  const std::string old_data = data ? data : "", old_home = home ? home : "";
  setenv("HOME", "/home/someone", 1);
  setenv("XDG_DATA_HOME", "/data", 1);
  EXPECT_EQ(default_data_directory(), "/data/photond");
  setenv("XDG_DATA_HOME", "relative", 1);
  EXPECT_EQ(default_data_directory(), "/home/someone/.local/share/photond");
  unsetenv("XDG_DATA_HOME");
  unsetenv("HOME");
  EXPECT_EQ(default_data_directory(), "");
  if (data) setenv("XDG_DATA_HOME", old_data.c_str(), 1);
  if (home) setenv("HOME", old_home.c_str(), 1);
}

}  // namespace
}  // namespace photond
