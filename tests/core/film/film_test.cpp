#include "core/film/film.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <random>

#include "core/film/reconstruct.h"
#include "core/math/rng.h"

namespace photond {
namespace {

constexpr int kWidth = 5, kHeight = 3;

PassImage constant(const Rgb& value) {
  PassImage image{.radiance = Image(2, 1)};
  image.radiance.pixels = {value, value};
  return image;
}

/// Values over the whole range that sums take, of both signs in the bands, in a few places not finite.
PassImage random_pass(std::uint32_t pass) {
  PassImage image{.radiance = Image(kWidth, kHeight), .bands = std::vector<Bands>(kWidth * kHeight)};
  Rng rng(7, RngPurpose::pilot, pass, 0);
  const auto magnitude = [&rng] { return std::exp2(60 * rng.next() - 25) * rng.next(); };
  for (std::size_t i = 0; i < image.radiance.pixels.size(); ++i) {
    image.radiance.pixels[i] = Rgb(magnitude(), magnitude(), rng.next());
    for (int j = 0; j < kBands; ++j) {
      image.bands[i].value[j] = Rgb(magnitude() * (rng.next() - 0.5f), 0, rng.next() - 0.5f);
      image.bands[i].variance[j] = magnitude();
    }
  }
  if (pass % 5 == 0) image.radiance.pixels[pass % 15].y = std::nanf("");
  if (pass % 7 == 0) image.bands[pass % 15].value[pass % kBands].x = kInfinity;
  if (pass % 11 == 0) image.bands[pass % 15].variance[pass % kBands] = kInfinity;
  return image;
}

Film film_of(const std::vector<std::uint32_t>& passes, const Execution& execution = {}) {
  Film film(kWidth, kHeight);
  for (std::uint32_t pass : passes) add_pass(film, pass, random_pass(pass), execution);
  return film;
}

std::vector<std::uint32_t> first_passes(std::uint32_t count) {
  std::vector<std::uint32_t> passes(count);
  std::iota(passes.begin(), passes.end(), 0u);
  return passes;
}

void expect_equal(const Film& a, const Film& b) {
  EXPECT_EQ(a.passes, b.passes);
  EXPECT_EQ(a.rejected, b.rejected);
  EXPECT_EQ(a.blocks, b.blocks);
  EXPECT_TRUE(a.complete == b.complete);
  EXPECT_TRUE(a.block_squares == b.block_squares);
  EXPECT_TRUE(a.pass_squares == b.pass_squares);
  EXPECT_TRUE(a.largest == b.largest);
  ASSERT_EQ(a.bands.size(), b.bands.size());
  for (std::size_t i = 0; i < a.bands.size(); ++i) {
    EXPECT_TRUE(a.bands[i].value == b.bands[i].value);
    EXPECT_TRUE(a.bands[i].variance == b.bands[i].variance);
  }
  ASSERT_EQ(a.open.size(), b.open.size());
  for (std::size_t i = 0; i < a.open.size(); ++i) {
    EXPECT_EQ(a.open[i].index, b.open[i].index);
    EXPECT_EQ(a.open[i].passes, b.open[i].passes);
    EXPECT_TRUE(a.open[i].sum == b.open[i].sum);
  }
  EXPECT_TRUE(film_picture(a).pixels == film_picture(b).pixels);
}

TEST(ExactSum, IsExactWhereDoublesAreNot) {
  ExactSum sum;
  sum.add(0x1p35f);
  sum.add(0x1p-40f);
  sum.add(-0x1p35f);
  EXPECT_EQ(sum.value(), 0x1p-40);
  sum.add(-0x1p-39f);
  EXPECT_EQ(sum.value(), -0x1p-40);
  sum.add(0.0f);
  sum.add(-0.0f);
  sum.add(0x1p-140f);  // denormal: below the unit
  EXPECT_EQ(sum.value(), -0x1p-40);
}

// Of any exponent and sign that a sum takes; now and then a zero.
float any_summand(Rng& rng) {
  const float largest = std::nextafter(kLargestSummand, 0.0f);
  const std::uint32_t bits = rng.next_uint();
  if (bits % 16 == 0) return bits & 16 ? -0.0f : 0.0f;
  return std::clamp(std::bit_cast<float>(bits & 0x40000000u ? bits & 0xd2ffffffu : bits), -largest, largest);
}

// On sums of any bits; and counts that no vector divides.
TEST(ExactSum, ManyAtOnceAreWhatEachIs) {
  constexpr std::size_t kMost = 23;
  Rng rng(3, RngPurpose::pilot, 0, 0);
  for (int round = 0; round < 20'000; ++round) {
    const std::size_t count = rng.next_uint() % (kMost + 1);
    std::array<ExactSum, kMost> one, all;
    std::array<float, kMost> x;
    for (std::size_t i = 0; i < kMost; ++i) {
      x[i] = any_summand(rng);
      for (int word = 0; word < 4; ++word) one[i].bits = one[i].bits << 32 | (rng.next_uint() | (word == round % 5 ? ~0u : 0));
      all[i] = one[i];
    }
    for (std::size_t i = 0; i < count; ++i) one[i].add(x[i]);
    add(all.data(), x.data(), count);
    ASSERT_EQ(all, one);
    std::array<double, kMost> sums{};
    values(all.data(), sums.data(), count);
    for (std::size_t i = 0; i < kMost; ++i) ASSERT_EQ(sums[i], i < count ? one[i].value() : 0);
  }
}

TEST(ExactSum, ManySquaresAtOnceAreWhatEachIs) {
  constexpr std::size_t kMost = 23;
  Rng rng(4, RngPurpose::pilot, 0, 0);
  for (int round = 0; round < 20'000; ++round) {
    const std::size_t count = rng.next_uint() % (kMost + 1);
    std::array<ExactSquareSum, kMost> one, all;
    std::array<float, kMost> x;
    for (std::size_t i = 0; i < kMost; ++i) {
      x[i] = any_summand(rng);
      // Words that are full now and then: what is added carries through them.
      for (std::size_t word = 0; word < 3; ++word) {
        const std::uint64_t full = rng.next_uint() % 3 == 0 && word < 2 ? ~std::uint64_t{0} : 0;
        one[i].words[word] = full | (std::uint64_t{rng.next_uint()} << 32 | rng.next_uint());
      }
      all[i] = one[i];
    }
    for (std::size_t i = 0; i < count; ++i) one[i].add_square(static_cast<double>(x[i]));
    add_squares(all.data(), x.data(), count);
    ASSERT_EQ(all, one);
    std::array<double, kMost> sums{};
    values(all.data(), sums.data(), count);
    for (std::size_t i = 0; i < kMost; ++i) ASSERT_EQ(sums[i], i < count ? one[i].value() : 0);
  }
}

TEST(ExactSum, SquaresCoverTheirRange) {
  for (int exponent = -40; exponent < 36; ++exponent) {
    for (double x : {std::ldexp(1.0, exponent), std::ldexp(-1.9, exponent), std::ldexp(1.2345678, exponent)}) {
      ExactSquareSum sum;
      sum.add_square(x);
      // Cut at 2⁻⁹⁶ or at 53 bits.
      EXPECT_NEAR(sum.value(), x * x, 0x1p-96 + 0x1p-52 * x * x) << x;
    }
  }
  ExactSquareSum sum;
  for (int i = 0; i < 1024; ++i) sum.add_square(0x1.fffffep35);
  EXPECT_NEAR(sum.value() / 1024, 0x1.fffffep35 * 0x1.fffffep35, 0x1p20);
}

/// Case 39: the sum of 10⁹ values is exact, where a float ends at 2²⁴ times its summand.
TEST(ExactSum, ABillionAdditionsLoseNothing) {
  constexpr int kAdditions = 1'000'000'000, kValues = 1000;
  std::array<float, kValues> values{};
  double once = 0;  // exact: multiples of 2⁻²⁴ below 2¹⁰
  Rng rng(9, RngPurpose::pilot, 0, 0);
  for (float& value : values) once += value = rng.next();
  ExactSum sum;
  for (int i = 0; i < kAdditions / kValues; ++i) {
    for (float value : values) sum.add(value);
  }
  EXPECT_EQ(sum.value(), once * (kAdditions / kValues));
}

TEST(Film, MeanOfPasses) {
  Film film(2, 1);
  EXPECT_EQ(film_picture(film).pixels[0], Rgb(0));
  add_pass(film, 0, constant(Rgb(1, 2, 3)));
  add_pass(film, 1, constant(Rgb(3, 2, 1)));
  EXPECT_EQ(film.pass_count(), 2u);
  EXPECT_EQ(film.passes, (std::vector<PassRange>{{0, 2}}));
  EXPECT_EQ(film_picture(film).pixels[1], Rgb(2));
}

TEST(Film, RejectsWhatIsNotFiniteOrTooLarge) {
  Film film(2, 1);
  for (const Rgb& bad : {Rgb(0, 0, std::nanf("")), Rgb(kInfinity, 0, 0), Rgb(0, -2 * kLargestSummand, 0)}) {
    PassImage pass = constant(Rgb(1));
    pass.radiance.pixels[0] = bad;
    add_pass(film, film.pass_count(), pass);
  }
  EXPECT_EQ(film.rejected, 3u);
  EXPECT_EQ(film_picture(film).pixels[0], Rgb(0));
  EXPECT_EQ(film_picture(film).pixels[1], Rgb(1));
}

TEST(Film, KeepsLightWhoseNoiseIsTooLargeToTell) {
  Film film(1, 1);
  PassImage pass{.radiance = Image(1, 1), .bands = std::vector<Bands>(1)};
  pass.radiance.pixels[0] = Rgb(3e5f);
  pass.bands[0].value[0] = Rgb(1e5f);
  pass.bands[0].variance[0] = kInfinity;
  add_pass(film, 0, pass);
  EXPECT_EQ(film.rejected, 0u);
  EXPECT_EQ(pass_mean(film, 0), glm::dvec3(static_cast<double>(3e5f)));
  pass.bands[0].variance[0] = std::nanf("");
  add_pass(film, 1, pass);
  EXPECT_EQ(film.rejected, 1u);
}

TEST(Film, BlocksCloseWhenTheirLastPassComes) {
  Film film = film_of(first_passes(47));
  EXPECT_EQ(film.blocks, 2u);
  ASSERT_EQ(film.open.size(), 1u);
  EXPECT_EQ(film.open[0].index, 2u);
  EXPECT_EQ(film.open[0].passes, 0x7fff);
  add_pass(film, 47, random_pass(47));
  EXPECT_EQ(film.blocks, 3u);
  EXPECT_TRUE(film.open.empty());
}

TEST(Film, TheOrderOfThePassesDoesNotMatter) {
  std::vector<std::uint32_t> passes = first_passes(75);
  const Film whole = film_of(passes);
  std::mt19937 random(1);
  for (int repeat = 0; repeat < 5; ++repeat) {
    std::shuffle(passes.begin(), passes.end(), random);
    expect_equal(film_of(passes), whole);
  }
}

TEST(Film, AnySplitMergesToTheSameBits) {
  std::mt19937 random(2);
  for (std::uint32_t count : {3u, 16u, 40u, 64u, 75u, 131u}) {
    const Film whole = film_of(first_passes(count));
    for (int repeat = 0; repeat < 8; ++repeat) {
      std::vector<std::uint32_t> cuts = {0, count};
      for (std::uint32_t i = random() % 9; i > 0; --i) cuts.push_back(random() % (count + 1));
      std::sort(cuts.begin(), cuts.end());
      std::vector<Film> parts;
      for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        std::vector<std::uint32_t> passes;
        for (std::uint32_t pass = cuts[i]; pass < cuts[i + 1]; ++pass) passes.push_back(pass);
        parts.push_back(film_of(passes));
      }
      std::shuffle(parts.begin(), parts.end(), random);
      while (parts.size() > 1) {  // pairs at random: also ((a + c) + (b + d))
        std::swap(parts.back(), parts[random() % parts.size()]);
        Film last = std::move(parts.back());
        parts.pop_back();
        ASSERT_TRUE(merge_film(parts[random() % parts.size()], last).ok());
      }
      expect_equal(parts[0], whole);
    }
  }
}

TEST(Film, ThreadsDoNotChangeABit) {
  const Workers workers(4);
  Film one(301, 67), many(301, 67);
  for (std::uint32_t pass = 0; pass < 70; ++pass) {
    PassImage image{.radiance = Image(301, 67), .bands = std::vector<Bands>(301 * 67)};
    Rng rng(3, RngPurpose::pilot, pass, 0);
    for (Rgb& pixel : image.radiance.pixels) pixel = Rgb(rng.next(), 1e6f * rng.next(), 1e-6f * rng.next());
    for (Bands& bands : image.bands) bands.value[pass % kBands] = Rgb(rng.next() - 0.5f);
    add_pass(one, pass, image);
    add_pass(many, pass, image, workers.execution());
  }
  expect_equal(many, one);
}

TEST(Film, AStopDoesNotLeaveHalfAPass) {
  std::stop_source stop;
  stop.request_stop();
  const Workers workers(2);
  expect_equal(film_of({0, 1, 2}, workers.execution(stop.get_token())), film_of({0, 1, 2}));
}

TEST(Film, RefusesToMergeWhatDoesNotFit) {
  Film film = film_of({0, 1, 2, 3, 17});
  const Film before = film;
  const Status twice = merge_film(film, film_of({2, 3, 4}));
  ASSERT_FALSE(twice.ok());
  EXPECT_NE(twice.error().message.find("2:4"), std::string::npos) << twice.error().message;
  EXPECT_FALSE(merge_film(film, Film(kHeight, kWidth)).ok());
  expect_equal(film, before);
  EXPECT_TRUE(merge_film(film, film_of({4})).ok());
  EXPECT_EQ(film.passes, (std::vector<PassRange>{{0, 5}, {17, 18}}));
}

}  // namespace
}  // namespace photond
