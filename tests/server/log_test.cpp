#include "server/log.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace photond {
namespace {

/// What is logged between the object's making and `lines`.
class Logged {
 public:
  explicit Logged(LogLevel level) : file_(std::fopen(path().c_str(), "w")) { begin_log(level, file_); }
  ~Logged() { end_log(); }

  std::vector<nlohmann::json> lines() {
    end_log();
    std::fclose(file_);
    std::ifstream in(path());
    std::vector<nlohmann::json> all;
    for (std::string line; std::getline(in, line);) all.push_back(nlohmann::json::parse(line));
    return all;
  }

 private:
  std::string path() const { return folder_.file("log"); }
  test::TemporaryFolder folder_;
  std::FILE* file_;
};

TEST(Log, LinesAreJsonWithTimeAndLevel) {
  Logged log(LogLevel::info);
  LogLine(LogLevel::info, "request").with("path", "/v1/jobs").with("status", 200).with("ms", 1.5);
  const auto lines = log.lines();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0]["event"], "request");
  EXPECT_EQ(lines[0]["level"], "info");
  EXPECT_EQ(lines[0]["path"], "/v1/jobs");
  EXPECT_EQ(lines[0]["status"], 200);
  EXPECT_EQ(lines[0]["ms"], 1.5);
  EXPECT_EQ(lines[0]["time"].get<std::string>().size(), std::string("2026-01-31T12:00:00.123Z").size());
}

TEST(Log, HostileTextIsOneLine) {
  const std::string text("a\"\\\r\n\0{}%v\x1b[31m\xff\xc3\xa4", 18);
  Logged log(LogLevel::info);
  LogLine(LogLevel::info, text).with(text, text).with("n", std::numeric_limits<double>::quiet_NaN());
  const auto lines = log.lines();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(lines[0]["n"].is_null());
  EXPECT_TRUE(lines[0]["event"].get<std::string>().starts_with("a\"\\\r\n"));
}

TEST(Log, LowerLevelsAreLeftOut) {
  Logged log(LogLevel::warning);
  LogLine(LogLevel::debug, "a");
  LogLine(LogLevel::info, "b");
  LogLine(LogLevel::warning, "c");
  LogLine(LogLevel::error, "d");
  EXPECT_EQ(log.lines().size(), 2u);
}

TEST(Log, ThreadsMayWriteWhileItEnds) {
  Logged log(LogLevel::info);
  std::vector<std::thread> writers;
  for (int i = 0; i < 4; ++i) {
    writers.emplace_back([] {
      for (int k = 0; k < 500; ++k) LogLine(LogLevel::info, "line").with("k", k);
    });
  }
  end_log();
  for (std::thread& writer : writers) writer.join();
  for (const auto& line : log.lines()) EXPECT_EQ(line["event"], "line");
  LogLine(LogLevel::error, "after the end");
}

}  // namespace
}  // namespace photond
