// What becomes of an output: links are followed, devices and pipes stay what they are, and no signal leaves half a file.
#include "server/cli/files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include "server/cli/interrupt.h"
#include "tests/cli/program.h"

namespace photond::test {
namespace {

using namespace std::chrono_literals;

class FilesTest : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string file_ = folder_.file("file"), link_ = folder_.file("link");

  /// As the commands do it: checked first.
  static Status write(const std::string& path, const std::string& text) {
    const Status checked = check_outputs({path}, {});
    return checked ? write_file(path, std::as_bytes(std::span(text))) : checked;
  }

  std::size_t count() const {
    const std::filesystem::directory_iterator files(folder_.path());
    return static_cast<std::size_t>(std::distance(begin(files), end(files)));
  }
};

TEST_F(FilesTest, LinksAreFollowed) {
  write_text(file_, "old");
  std::filesystem::create_symlink("file", folder_.path() / "between");
  std::filesystem::create_symlink(folder_.path() / "between", link_);
  ASSERT_TRUE(write(link_, "new").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(link_));
  EXPECT_EQ(read_text(file_), "new");

  std::filesystem::remove(file_);
  ASSERT_TRUE(write(link_, "first").ok());
  EXPECT_EQ(read_text(file_), "first") << "what they lead to need not exist";
  EXPECT_EQ(count(), 3u);

  EXPECT_EQ(check_outputs({link_, file_}, {}).error().message, "would be written twice");
  std::filesystem::remove(file_);
  EXPECT_EQ(check_outputs({link_, file_}, {}).error().message, "would be written twice");
  std::filesystem::create_symlink("loop", folder_.path() / "loop");
  EXPECT_FALSE(write(folder_.file("loop"), "x").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(folder_.path() / "loop"));
}

TEST_F(FilesTest, APipeIsWrittenInto) {
  ASSERT_EQ(::mkfifo(file_.c_str(), 0600), 0);
  std::filesystem::create_symlink(file_, link_);
  std::string text(200'000, 'x'), got;
  std::thread reader([&] { got = read_text(file_); });
  EXPECT_TRUE(write(link_, text).ok());
  reader.join();
  EXPECT_EQ(got, text);
  EXPECT_TRUE(std::filesystem::is_fifo(file_));
  EXPECT_EQ(count(), 2u);
}

TEST_F(FilesTest, ADeviceStaysADevice) {
  if (::mknod(file_.c_str(), S_IFCHR | 0666, makedev(1, 3)) != 0) GTEST_SKIP() << "only root makes devices";
  if (::access("/dev/full", W_OK) != 0) GTEST_SKIP() << "devices cannot be opened here";
  std::filesystem::create_symlink(file_, link_);
  const Status written = write(link_, "nothing");
  EXPECT_TRUE(std::filesystem::is_character_file(file_));
  EXPECT_TRUE(std::filesystem::is_symlink(link_));
  if (!written) GTEST_SKIP() << "no device can be opened in the folder of temporary files";
  EXPECT_EQ(count(), 2u);
}

TEST_F(FilesTest, NamesThatLeadNowhereAreNoInputs) {
  std::filesystem::create_symlink(link_, link_);
  for (const std::string& name : {std::string(), std::string(260, 'n'), link_}) {
    const Status refused = check_outputs({name}, {""});
    ASSERT_FALSE(refused.ok()) << name;
    EXPECT_NE(refused.error().message.find("cannot be written"), std::string::npos) << refused.error().message;
  }
}

TEST_F(FilesTest, StandardOutputGoesOnWhereItIs) {
  const std::string scene = write_scene(folder_.path());
  write_text(file_, "before\n");
  const std::string line = "'" PHOTOND_PROGRAM "' render '" + scene + "' -o '" + folder_.file("a.exr") +
                           "' --size 8x8 --passes 1 --method path --report /proc/self/fd/1 >>'" + file_ + "' 2>'" +
                           folder_.file("err") + "'";
  EXPECT_EQ(std::system(line.c_str()), 0) << read_text(folder_.path() / "err");
  EXPECT_EQ(read_text(file_).substr(0, 9), "before\n{\n");
}

// A process that does nothing but write is ended while it does.
TEST_F(FilesTest, NoSignalLeavesHalfAFile) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const pid_t pid = ::fork();
    ASSERT_GE(pid, 0);
    if (pid == 0) {
      const Interrupt interrupt(Interrupt::Ends::at_first);
      const std::vector<std::byte> bytes(1 << 24);
      while (true) (void)write_file(file_, bytes).ok();
    }
    for (const auto end = std::chrono::steady_clock::now() + 10s; count() == 0;) {
      ASSERT_LT(std::chrono::steady_clock::now(), end);
      std::this_thread::sleep_for(1ms);
    }
    ::kill(pid, signal);
    EXPECT_EQ(wait_for_exit(pid), 128 + signal);
    std::filesystem::remove(file_);
    EXPECT_EQ(count(), 0u) << "signal " << signal;
  }
}

TEST_F(FilesTest, ALimitToTheSizeOfFilesIsAnErrorOfTheWrite) {
  const std::string scene = write_scene(folder_.path());
  const std::string line = "ulimit -f 1; '" PHOTOND_PROGRAM "' task '" + scene + "' --out '" + file_ +
                           "' --size 64x64 --passes 0:1 --method path 2>&1 | cat >'" + link_ + "'";
  std::system(line.c_str());
  EXPECT_EQ(read_text(link_), "photond: " + file_ + ": cannot write: File too large\n");
  std::filesystem::remove(link_);
  EXPECT_EQ(count(), 2u) << "of the scene";
}

}  // namespace
}  // namespace photond::test
