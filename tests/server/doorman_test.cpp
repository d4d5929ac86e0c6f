#include "server/http/doorman.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <utility>
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

/// A doorman who leaves the descriptors from `first free + connections` on to files.
class ShortOfDescriptors : public ::testing::Test {
 protected:
  void open(int connections) {
    DoormanOptions options;
    options.host = "127.0.0.1";
    const int free = ::dup(STDERR_FILENO);
    ::close(free);
    options.max_descriptor = free + connections;
    auto opened = Doorman::open(options);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    doorman_ = std::move(*opened);
  }
  void begin() {
    doorman_->begin({[](Arrival&& arrival) {
                       const Arrival entered = std::move(arrival);
                       return ::send(entered.socket.fd(), kAnswer.data(), kAnswer.size(), 0) > 0;
                     },
                     [this](Doorman::Loss loss) { ++losses_[static_cast<int>(loss)]; }});
  }
  std::string ask() const {
    test::Connection visitor(doorman_->port());
    visitor.send(kRequest);
    return visitor.read_all(5s);
  }

  std::array<std::atomic<int>, 4> losses_{};
  std::unique_ptr<Doorman> doorman_;
};

TEST_F(ShortOfDescriptors, WhoHasWaitedLongestMakesRoomAndFilesKeepTheirs) {
  open(60);  // 40 of them are the other ends
  std::vector<std::unique_ptr<test::Connection>> idle;
  for (int i = 0; i < 40; ++i) idle.push_back(std::make_unique<test::Connection>(doorman_->port()));
  begin();
  EXPECT_EQ(ask(), kAnswer) << "who asks comes in";
  EXPECT_GE(losses_[static_cast<int>(Doorman::Loss::crowded)], 20);
  idle.front()->read_all(1s);
  EXPECT_TRUE(idle.front()->closed());
}

TEST_F(ShortOfDescriptors, WhereNobodyWaitsTheNextOneHearsThatItIsBusy) {
  open(0);
  begin();
  EXPECT_TRUE(ask().starts_with("HTTP/1.1 503 "));
  EXPECT_EQ(losses_[static_cast<int>(Doorman::Loss::descriptors)], 1);
}

TEST(SpareDescriptor, LeavesSomeToFiles) {
  rlimit before{};
  ::getrlimit(RLIMIT_NOFILE, &before);
  for (const auto& [limit, spare] : {std::pair{256, 128}, std::pair{1024, 832}}) {
    const rlimit low{static_cast<rlim_t>(limit), before.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &low);
    EXPECT_EQ(spare_descriptor(), spare);
  }
  ::setrlimit(RLIMIT_NOFILE, &before);
}

}  // namespace
}  // namespace photond
