#include "server/store/keys.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <thread>

#include "tests/support/temporary_folder.h"

namespace photond {
namespace {

using test::TemporaryFolder;

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Keys, AreRandomAndKeptAsDigests) {
  TemporaryFolder folder;
  const KeyFile file(folder.path());
  std::set<std::string> secrets;
  for (int i = 0; i < 50; ++i) {
    const auto key = make_key(Scope::submit, {.jobs = 3, .bytes = {}, .streams = 5}, "build machine");
    ASSERT_TRUE(key.ok());
    secrets.insert(key->secret);
    EXPECT_EQ(key->secret.size(), 8u + 64u);
    ASSERT_TRUE(file.add(key->record).ok());
  }
  EXPECT_EQ(secrets.size(), 50u);
  const std::string text = text_of(file.path());
  for (const std::string& secret : secrets) EXPECT_EQ(text.find(secret.substr(8)), std::string::npos);
  const auto permissions = std::filesystem::status(file.path()).permissions();
  EXPECT_EQ(permissions & std::filesystem::perms::others_read, std::filesystem::perms::none);
  EXPECT_EQ(permissions & std::filesystem::perms::group_read, std::filesystem::perms::none);
}

TEST(Keys, AreReadAsTheyWereWritten) {
  TemporaryFolder folder;
  const KeyFile file(folder.path());
  EXPECT_TRUE(file.read().ok());
  EXPECT_FALSE(file.exists());
  const auto a = make_key(Scope::admin, {}, "");
  const auto b = make_key(Scope::read, {.jobs = 0, .bytes = 1ull << 40, .streams = {}}, "a  label, ü");
  ASSERT_TRUE(file.add(a->record).ok() && file.add(b->record).ok());
  const auto keys = file.read();
  ASSERT_TRUE(keys.ok());
  ASSERT_EQ(keys->size(), 2u);
  EXPECT_EQ((*keys)[0].scope, Scope::admin);
  EXPECT_EQ((*keys)[0].label, "");
  EXPECT_FALSE((*keys)[0].limits.jobs);
  EXPECT_EQ((*keys)[1].id, b->record.id);
  EXPECT_EQ((*keys)[1].hash, b->record.hash);
  EXPECT_EQ((*keys)[1].limits.jobs, 0u);
  EXPECT_EQ((*keys)[1].limits.bytes, 1ull << 40);
  EXPECT_FALSE((*keys)[1].limits.streams);
  EXPECT_EQ((*keys)[1].label, "a  label, ü");
  ASSERT_TRUE(file.revoke(a->record.id).ok());
  EXPECT_EQ(file.revoke(a->record.id).error().code, ErrorCode::not_found);
  EXPECT_EQ(file.read()->size(), 1u);
}

TEST(Keys, ALabelIsOneLine) {
  EXPECT_FALSE(make_key(Scope::read, {}, "a\nk-0 forged").ok());
  EXPECT_FALSE(make_key(Scope::read, {}, std::string(101, 'a')).ok());
}

TEST(Keys, ADamagedFileIsNoEmptyOne) {
  TemporaryFolder folder;
  const KeyFile file(folder.path());
  ASSERT_TRUE(file.add(make_key(Scope::read, {}, "x")->record).ok());
  const std::string whole = text_of(file.path());
  const std::string cases[] = {"", "photond", whole + "k-1 abc read - - - 1 x\n", whole.substr(1),
                               whole + "k-00000000 " + std::string(64, '0') + " root - - - 1 x\n"};
  for (const std::string& text : cases) {
    std::ofstream(file.path(), std::ios::trunc) << text;
    EXPECT_EQ(file.read().ok() ? ErrorCode::internal : file.read().error().code, ErrorCode::io) << text;
    EXPECT_FALSE(file.add(make_key(Scope::read, {}, "")->record).ok()) << "nothing is written over it";
    EXPECT_EQ(text_of(file.path()), text);
  }
}

TEST(Keys, SeveralProgramsMayChangeThemAtOnce) {
  TemporaryFolder folder;
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&folder] {
      for (int k = 0; k < 5; ++k) EXPECT_TRUE(KeyFile(folder.path()).add(make_key(Scope::read, {}, "")->record).ok());
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(KeyFile(folder.path()).read()->size(), 40u);
}

TEST(Keyring, SeesEveryChangeOfTheFile) {
  TemporaryFolder folder;
  const KeyFile file(folder.path());
  const Keyring ring(file);
  EXPECT_FALSE(ring.required());
  for (int i = 0; i < 20; ++i) {
    const auto key = make_key(Scope::read, {}, "");
    ASSERT_TRUE(file.add(key->record).ok());
    EXPECT_TRUE(ring.required());
    EXPECT_TRUE(ring.find(key->secret)->has_value());
    EXPECT_FALSE(ring.find(key->secret + "x")->has_value());
    ASSERT_TRUE(file.revoke(key->record.id).ok());
    EXPECT_FALSE(ring.find(key->secret)->has_value()) << "of the same size, at almost the same time";
  }
  std::filesystem::remove(file.path());
  EXPECT_TRUE(ring.required()) << "a file that goes opens nothing";
  EXPECT_FALSE(Keyring(std::nullopt).required());
}

}  // namespace
}  // namespace photond
