#include "server/http/doorman.h"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <atomic>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "tests/server/http_client.h"

namespace photond {
namespace {

using namespace std::chrono_literals;

constexpr const char* kRequest = "GET / HTTP/1.1\r\nHost: x\r\n\r\n";
constexpr std::string_view kAnswer = "HTTP/1.1 204 No Content\r\n\r\n";

/// A doorman whose first visitors find no memory.
class ShortOfMemory : public ::testing::Test {
 protected:
  void SetUp() override {
    DoormanOptions options;
    options.host = "127.0.0.1";
    options.patience = 100ms;
    auto opened = Doorman::open(options);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    doorman_ = std::move(*opened);
    doorman_->begin({[this](Arrival&& arrival) { return enter(std::move(arrival)); },
                     [](Doorman::Loss) { throw std::bad_alloc(); }});
  }

  bool enter(Arrival&& arrival) {
    if (failures_-- > 0) throw std::bad_alloc();
    const Arrival entered = std::move(arrival);
    EXPECT_GT(::send(entered.socket.fd(), kAnswer.data(), kAnswer.size(), 0), 0);
    return true;
  }

  std::string ask() const {
    test::Connection visitor(doorman_->port());
    visitor.send(kRequest);
    return visitor.read_all(5s);
  }

  std::atomic<int> failures_ = 2;
  std::unique_ptr<Doorman> doorman_;
};

TEST_F(ShortOfMemory, DropsTheOneVisitorWhoCannotEnter) {
  EXPECT_EQ(ask(), "");
  EXPECT_EQ(ask(), "");
  EXPECT_EQ(ask(), kAnswer);
}

TEST_F(ShortOfMemory, ShowsDawdlersOutThoughItCannotCountThem) {
  failures_ = 0;
  std::vector<std::unique_ptr<test::Connection>> dawdlers;
  for (int i = 0; i < 3; ++i) dawdlers.push_back(std::make_unique<test::Connection>(doorman_->port()));
  for (const auto& dawdler : dawdlers) {
    dawdler->read_all(5s);
    EXPECT_TRUE(dawdler->closed());
  }
  EXPECT_EQ(ask(), kAnswer);
}

}  // namespace
}  // namespace photond
