#include "core/photon/packed_flux.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/statistics.h"

namespace photond {
namespace {

// Over all random numbers the mean is the value itself: the sum of 2^15 floats of 9 bits is exact in double, and so is
// the comparison.
TEST(PackedFlux, MeanOfTheRoundedIsTheValue) {
  Rng rng(21, RngPurpose::pilot, 0, 0);
  std::vector<float> values{0, -0.0f, 1, 1e-3f, 1e-12f, 1e12f, 0x1.fffffep0f, 0x1.fffffep-127f, 3e-45f, 2e-39f};
  for (int i = 0; i < 50; ++i) values.push_back(std::exp2(80 * rng.next() - 40));
  for (const float value : values) {
    double sum = 0;
    for (std::uint32_t random = 0; random < 0x8000; ++random) {
      const float rounded = decode_flux(encode_flux(value, random));
      // Subnormal floats have no relative precision.
      const float step = std::max(value / 256, 0x1p-134f);
      ASSERT_NEAR(rounded, value, step) << value;
      sum += rounded;
    }
    EXPECT_EQ(sum / 0x8000, value);
  }
}

// A dim channel beside a bright one, and colours of any scale: no channel loses, as it would by truncation (2.8 % at a
// tenth of the brightest) or by a shared exponent.
TEST(PackedFlux, ColoursKeepTheirEnergy) {
  for (const Rgb& colour : {Rgb(1, 1.2345e-3f, 1.2345e-3f), Rgb(1e-12f, 1e12f, 0.1f), Rgb(0.0999f, 0.9f, 3.3e-7f)}) {
    test::Sample relative[3];
    for (std::uint32_t key = 0; key < 100'000; ++key) {
      const PackedFlux packed = encode_flux(colour, key);
      for (int c = 0; c < 3; ++c) relative[c].add(static_cast<double>(decode_flux(packed[c])) / colour[c] - 1);
    }
    for (const test::Sample& channel : relative) {
      EXPECT_TRUE(test::agrees(channel, 0)) << channel.mean << " ± " << channel.standard_error();
      // Uniform rounding to steps of 1/256 … 1/512 has a standard deviation of at most half a step.
      EXPECT_LT(channel.standard_error() * std::sqrt(1e5), 1.0 / 512);
    }
  }
}

// The three channels of a photon and photons that follow each other are rounded independently.
TEST(PackedFlux, RoundingErrorsAreUncorrelated) {
  const float value = 1 + 1.0f / 512;                 // half way between two neighbours
  const auto error = [&](std::uint32_t key, int c) { return decode_flux(encode_flux(Rgb(value), key)[c]) - value; };
  test::Sample channels;
  test::Sample neighbours;
  for (std::uint32_t key = 0; key < 100'000; ++key) {
    channels.add(error(key, 0) * error(key, 1));
    neighbours.add(error(key, 2) * error(key + 1, 2));
  }
  EXPECT_TRUE(test::agrees(channels, 0));
  EXPECT_TRUE(test::agrees(neighbours, 0));
}

TEST(PackedFlux, SaturatesAtFiniteValues) {
  EXPECT_TRUE(std::isfinite(decode_flux(encode_flux(std::numeric_limits<float>::max(), 0x7fff))));
  EXPECT_TRUE(std::isfinite(decode_flux(encode_flux(kInfinity, 0x7fff))));
}

}  // namespace
}  // namespace photond
