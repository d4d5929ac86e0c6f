#include "core/base/zeroed_array.h"

#include <cstdint>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

namespace photond {
namespace {

struct Sum {
  std::uint64_t low = 0;
  double high = 0;
};

TEST(ZeroedArray, IsZeroEvenWhereMemoryWasUsedBefore) {
  for (const std::size_t size : {1u, 1000u, 3u << 20}) {
    for (int round = 0; round < 3; ++round) {
      ZeroedArray<Sum> values(size);
      ASSERT_EQ(values.size(), size);
      for (const Sum& value : values) ASSERT_TRUE(value.low == 0 && value.high == 0) << size << " in round " << round;
      for (Sum& value : values) value = {~0ull, -1};
    }
  }
}

TEST(ZeroedArray, IsCopiedAndMoved) {
  ZeroedArray<int> values(1000);
  values[999] = 7;
  const ZeroedArray<int> copy = values;
  values[999] = 8;
  const ZeroedArray<int> moved = std::move(values);
  EXPECT_EQ(copy[999], 7);
  EXPECT_EQ(moved[999], 8);
  EXPECT_TRUE(values.empty());  // NOLINT: as promised
  values = copy;
  EXPECT_EQ(values[999], 7);
  values = {};
  EXPECT_TRUE(values.empty());
  EXPECT_EQ(values.begin(), values.end());
}

std::size_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::size_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * 4096;
}

TEST(ZeroedArray, CostsNothingUntilItIsTouched) {
  constexpr std::size_t kBytes = std::size_t{1} << 30;
  const std::size_t before = resident_bytes();
  const ZeroedArray<double> values(kBytes / sizeof(double));
  EXPECT_LT(resident_bytes(), before + kBytes / 16);
}

TEST(ZeroedArray, ThrowsWhereThereIsNotSoMuch) {
  EXPECT_THROW(ZeroedArray<std::byte>(std::size_t{1} << 60), std::bad_alloc);
}

}  // namespace
}  // namespace photond
