#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>

#include "tests/cli/program.h"

namespace photond::test {
namespace {

/// An environment variable that has another value while this lives.
class Setting {
 public:
  Setting(const char* name, const std::string& value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    ::setenv(name, value.c_str(), 1);
  }
  ~Setting() { old_ ? ::setenv(name_, old_->c_str(), 1) : ::unsetenv(name_); }
  Setting(const Setting&) = delete;
  Setting& operator=(const Setting&) = delete;

 private:
  const char* const name_;
  std::optional<std::string> old_;
};

TEST(KeyCommand, UsesTheFolderThatServeUses) {
  const TemporaryFolder folder;
  const Setting home("XDG_DATA_HOME", folder.path().string());
  const Outcome made = run_photond({"key", "create", "--scope", "admin", "--label", "mine"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_EQ(made.out.substr(0, 8), "photond_");
  EXPECT_NE(read_text(folder.path() / "photond" / "keys").find("mine"), std::string::npos);
  const Outcome list = run_photond({"key", "list"});
  EXPECT_NE(list.out.find("mine"), std::string::npos) << list.err;
  // serve refuses a public address unless it finds a key; one that cannot be bound ends it there.
  const Outcome served = run_photond({"serve", "--host", "192.0.2.1", "--port", "0"});
  EXPECT_EQ(served.err.find("make a key"), std::string::npos) << served.err;
  EXPECT_EQ(served.code, 1);
}

TEST(KeyCommand, OnlyCreateMakesTheFolderAndSaysSo) {
  const TemporaryFolder folder;
  const std::string data = folder.file("data");
  const Outcome revoked = run_photond({"key", "revoke", "k-00000000", "--data", data});
  EXPECT_EQ(revoked.code, 1);
  EXPECT_EQ(revoked.err, "photond: cannot revoke: there is no folder " + data + "\n");
  EXPECT_FALSE(std::filesystem::exists(data));
  const std::string note = "photond: the folder " + data + " was not there and is made\n";
  EXPECT_EQ(run_photond({"key", "create", "--scope", "read", "--data", data}).err.find(note), 0u);
  EXPECT_EQ(run_photond({"key", "create", "--scope", "read", "--data", data}).err.find(note), std::string::npos);
}

}  // namespace
}  // namespace photond::test
