#include "server/jobs/scheduler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <mutex>
#include <string>

namespace photond {
namespace {

/// Writes down who had a turn.
class Diary {
 public:
  void write(char name) {
    const std::lock_guard lock(mutex_);
    text_ += name;
  }
  std::string text() const {
    const std::lock_guard lock(mutex_);
    return text_;
  }

 private:
  mutable std::mutex mutex_;
  std::string text_;
};

class FakeWork : public Slices {
 public:
  FakeWork(Diary& diary, char name, int slices, std::string owner = {})
      : diary_(diary), name_(name), left_(slices), owner_(std::move(owner)) {}
  bool step() override {
    diary_.write(name_);
    return --left_ > 0;
  }
  std::string owner() const override { return owner_; }

 private:
  Diary& diary_;
  const char name_;
  int left_;
  const std::string owner_;
};

/// Has something to show from its third slice on.
class FreshWork : public FakeWork {
 public:
  using FakeWork::FakeWork;
  bool step() override {
    --unseen_slices_;
    return FakeWork::step();
  }
  bool unseen() const override { return unseen_slices_ > 0; }

 private:
  int unseen_slices_ = 2;
};

/// Holds the scheduler's thread until told to go on, so that a test can fill the queue.
class Gate : public Slices {
 public:
  bool step() override {
    entered_ = true;
    while (!open_) std::this_thread::yield();
    return false;
  }
  void wait_entered() const {
    while (!entered_) std::this_thread::yield();
  }
  void open() { open_ = true; }

 private:
  std::atomic<bool> entered_ = false;
  std::atomic<bool> open_ = false;
};

constexpr std::uint64_t kMemory = 100;

/// Holds memory while it takes turns.
class LargeWork : public FakeWork {
 public:
  LargeWork(Diary& diary, char name, int slices, std::uint64_t memory, std::string owner = {})
      : FakeWork(diary, name, slices, std::move(owner)), memory_(memory) {}
  std::uint64_t memory() const override { return memory_; }

 private:
  const std::uint64_t memory_;
};

std::string run_all(const std::function<void(Scheduler&, Diary&)>& submit, std::size_t turns) {
  Diary diary;
  Scheduler scheduler(kMemory);
  const auto gate = std::make_shared<Gate>();
  scheduler.submit(gate, Priority::interactive);
  gate->wait_entered();
  submit(scheduler, diary);
  gate->open();
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (diary.text().size() < turns && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  scheduler.stop();
  return diary.text();
}

TEST(Scheduler, AnotherOwnersWorkNeedNotWaitForAFlood) {
  const std::string turns = run_all(
      [](Scheduler& scheduler, Diary& diary) {
        for (int i = 0; i < 100; ++i)
          scheduler.submit(std::make_shared<FakeWork>(diary, 'a', 100, "flood"), Priority::interactive);
        for (int i = 0; i < 3; ++i)
          scheduler.submit(std::make_shared<FakeWork>(diary, 'b', 100, "other"), Priority::interactive);
      },
      400);
  EXPECT_LT(turns.find('b'), Scheduler::kMaxActive + 2);
  const auto of_other = std::count(turns.begin(), turns.begin() + 400, 'b');
  EXPECT_GE(of_other, 400 / 12) << "goes on in turns";
  EXPECT_LE(of_other, 400 / 4) << "and is not preferred";
}

TEST(Scheduler, JobsOfAClassTakeTurns) {
  const std::string turns = run_all(
      [](Scheduler& scheduler, Diary& diary) {
        scheduler.submit(std::make_shared<FakeWork>(diary, 'a', 4), Priority::batch);
        scheduler.submit(std::make_shared<FakeWork>(diary, 'b', 2), Priority::batch);
        scheduler.submit(std::make_shared<FakeWork>(diary, 'c', 3), Priority::batch);
      },
      9);
  EXPECT_EQ(turns, "abcabcaca");
}

TEST(Scheduler, InteractiveGoesBeforeBatch) {
  const std::string turns = run_all(
      [](Scheduler& scheduler, Diary& diary) {
        scheduler.submit(std::make_shared<FakeWork>(diary, 'b', 2), Priority::batch);
        scheduler.submit(std::make_shared<FakeWork>(diary, 'i', 3), Priority::interactive);
        scheduler.submit(std::make_shared<FakeWork>(diary, 'j', 1), Priority::interactive);
      },
      6);
  EXPECT_EQ(turns, "ijiibb");
}

TEST(Scheduler, OnlySoManyTakeTurnsAtOnce) {
  const std::string turns = run_all(
      [](Scheduler& scheduler, Diary& diary) {
        for (char name = 'a'; name < 'a' + 9; ++name) {
          scheduler.submit(std::make_shared<FakeWork>(diary, name, name == 'a' ? 1 : 2), Priority::batch);
        }
      },
      17);
  EXPECT_EQ(turns,
            "abcdefgh"
            "ibcdefghi")
      << "the ninth waits until the first has ended";
}

TEST(Scheduler, WhatHasNoRoomInMemoryWaits) {
  const std::string turns = run_all(
      [](Scheduler& scheduler, Diary& diary) {
        scheduler.submit(std::make_shared<LargeWork>(diary, 'a', 2, 60), Priority::batch);
        scheduler.submit(std::make_shared<LargeWork>(diary, 'b', 4, 40), Priority::batch);
        scheduler.submit(std::make_shared<LargeWork>(diary, 'c', 2, 50), Priority::batch);
        scheduler.submit(std::make_shared<LargeWork>(diary, 'd', 1, 10), Priority::batch);
      },
      9);
  EXPECT_EQ(turns, "ababcdbcb") << "and what comes later does not pass it";
}

TEST(Scheduler, OtherOwnersAndOtherClassesShareTheMemory) {
  const std::string turns = run_all(
      [](Scheduler& scheduler, Diary& diary) {
        scheduler.submit(std::make_shared<LargeWork>(diary, 'a', 2, 60, "one"), Priority::interactive);
        scheduler.submit(std::make_shared<LargeWork>(diary, 'b', 2, 60, "two"), Priority::interactive);
        scheduler.submit(std::make_shared<LargeWork>(diary, 'c', 2, 40, "three"), Priority::interactive);
        scheduler.submit(std::make_shared<LargeWork>(diary, 'd', 1, 100, "four"), Priority::batch);
      },
      7);
  EXPECT_EQ(turns, "acacbbd");
}

TEST(Scheduler, WhatNeedsMoreThanThereIsTakesItsTurnsAlone) {
  const std::string turns = run_all(
      [](Scheduler& scheduler, Diary& diary) {
        scheduler.submit(std::make_shared<LargeWork>(diary, 'a', 2, 10), Priority::batch);
        scheduler.submit(std::make_shared<LargeWork>(diary, 'b', 2, 200), Priority::batch);
        scheduler.submit(std::make_shared<LargeWork>(diary, 'c', 1, 10), Priority::batch);
      },
      5);
  EXPECT_EQ(turns, "aabbc");
}

TEST(Scheduler, WaitingWorkThatIsHurriedHasItsTurnAtOnce) {
  const auto large = [](Diary& diary) { return std::make_shared<LargeWork>(diary, 'b', 1, 90); };
  const std::string turns = run_all(
      [&](Scheduler& scheduler, Diary& diary) {
        scheduler.submit(std::make_shared<LargeWork>(diary, 'a', 2, 90), Priority::batch);
        const auto waiting = large(diary);
        scheduler.submit(waiting, Priority::batch);
        EXPECT_TRUE(scheduler.hurry(waiting));
        scheduler.submit(std::make_shared<LargeWork>(diary, 'c', 1, 10), Priority::batch);
      },
      4);
  EXPECT_EQ(turns, "baca") << "and nothing comes in beside both";
}

TEST(Scheduler, HurriedWorkHasTheNextTurnAndThenItsUsualOnes) {
  bool queued = false, unknown = true;
  const std::string turns = run_all(
      [&](Scheduler& scheduler, Diary& diary) {
        const auto work = std::make_shared<FakeWork>(diary, 'x', 3);
        scheduler.submit(std::make_shared<FakeWork>(diary, 'i', 2), Priority::interactive);
        scheduler.submit(std::make_shared<FakeWork>(diary, 'b', 1), Priority::batch);
        scheduler.submit(work, Priority::batch);
        queued = scheduler.hurry(work) && scheduler.hurry(work);
        unknown = scheduler.hurry(std::make_shared<FakeWork>(diary, 'n', 1));
      },
      6);
  EXPECT_TRUE(queued);
  EXPECT_FALSE(unknown);
  EXPECT_EQ(turns, "xiibxx");
}

TEST(Scheduler, WhatNobodyHasSeenYetGoesBeforeTheRest) {
  const std::string turns = run_all(
      [](Scheduler& scheduler, Diary& diary) {
        scheduler.submit(std::make_shared<FakeWork>(diary, 'a', 3), Priority::interactive);
        scheduler.submit(std::make_shared<FakeWork>(diary, 'b', 2), Priority::interactive);
        scheduler.submit(std::make_shared<FreshWork>(diary, 'f', 4), Priority::interactive);
      },
      9);
  EXPECT_EQ(turns, "ffabfabfa") << "two turns at once, then as everybody";
}

TEST(Scheduler, WhatNobodyHasSeenYetTakesOnlyTurnsOfItsOwner) {
  const std::string turns = run_all(
      [](Scheduler& scheduler, Diary& diary) {
        scheduler.submit(std::make_shared<FakeWork>(diary, 'o', 3, "other"), Priority::interactive);
        scheduler.submit(std::make_shared<FakeWork>(diary, 'a', 2, "mine"), Priority::interactive);
        scheduler.submit(std::make_shared<FreshWork>(diary, 'f', 3, "mine"), Priority::interactive);
      },
      8);
  EXPECT_EQ(turns, "ofofoafa") << "one turn of the other's for each of mine, as without it";
}

TEST(Scheduler, IsIdleWhenAllIsDone) {
  Diary diary;
  Scheduler scheduler(kMemory);
  EXPECT_TRUE(scheduler.wait_idle(std::chrono::seconds(10)));
  const auto gate = std::make_shared<Gate>();
  scheduler.submit(gate, Priority::batch);
  gate->wait_entered();
  EXPECT_FALSE(scheduler.wait_idle(std::chrono::milliseconds(1)));
  scheduler.submit(std::make_shared<FakeWork>(diary, 'a', 3), Priority::batch);
  gate->open();
  EXPECT_TRUE(scheduler.wait_idle(std::chrono::seconds(10)));
  EXPECT_EQ(diary.text(), "aaa");
}

TEST(Scheduler, StopsWithWorkLeft) {
  Diary diary;
  Scheduler scheduler(kMemory);
  scheduler.submit(std::make_shared<FakeWork>(diary, 'a', 1'000'000'000), Priority::batch);
  scheduler.stop();
  const std::string before = diary.text();
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(diary.text(), before);
}

}  // namespace
}  // namespace photond
