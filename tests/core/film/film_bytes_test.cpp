#include "core/film/film_bytes.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/film/reconstruct.h"
#include "core/math/rng.h"

namespace photond {
namespace {

Film film_of(const std::vector<std::uint32_t>& passes, bool banded) {
  Film film(4, 3);
  for (std::uint32_t pass : passes) {
    PassImage image{.radiance = Image(4, 3), .bands = std::vector<Bands>(banded ? 12 : 0)};
    Rng rng(1, RngPurpose::pilot, pass, 0);
    for (Rgb& pixel : image.radiance.pixels) pixel = Rgb(rng.next(), 1e5f * rng.next(), 0);
    for (Bands& bands : image.bands) {
      for (Rgb& value : bands.value) value = Rgb(rng.next() - 0.5f);
      for (float& variance : bands.variance) variance = rng.next();
    }
    add_pass(film, pass, image);
  }
  return film;
}

std::vector<std::uint32_t> range(std::uint32_t first, std::uint32_t last) {
  std::vector<std::uint32_t> passes;
  for (std::uint32_t pass = first; pass < last; ++pass) passes.push_back(pass);
  return passes;
}

TEST(FilmBytes, ComeBackAsTheSameFilm) {
  const std::vector<std::vector<std::uint32_t>> sets = {
      {}, {0}, {5, 6, 7}, range(0, 16), range(3, 70), range(16, 160), {0, 2, 17, 31, 32, 900}, {UINT32_MAX - 1}};
  for (const auto& passes : sets) {
    for (bool banded : {false, true}) {
      const Film film = film_of(passes, banded);
      const std::vector<std::byte> bytes = film_bytes(film);
      const Result<Film> back = read_film(bytes);
      ASSERT_TRUE(back.ok()) << back.error().message;
      EXPECT_EQ(back->passes, film.passes);
      EXPECT_EQ(back->blocks, film.blocks);
      ASSERT_EQ(back->open.size(), film.open.size());
      for (std::size_t i = 0; i < film.open.size(); ++i) {
        EXPECT_EQ(back->open[i].index, film.open[i].index);
        EXPECT_EQ(back->open[i].passes, film.open[i].passes);
      }
      EXPECT_EQ(film_picture(*back).pixels, film_picture(film).pixels);
      EXPECT_TRUE(film_bytes(*back) == bytes);
    }
  }
}

TEST(FilmBytes, EveryOtherLengthIsRefused) {
  std::vector<std::byte> bytes = film_bytes(film_of(range(3, 20), true));
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_FALSE(read_film(std::span(bytes).first(length)).ok()) << length;
  }
  bytes.push_back({});
  EXPECT_FALSE(read_film(bytes).ok());
}

/// Every number of the head at extreme values: no crash, no large allocation, and never a film that is not consistent.
TEST(FilmBytes, HostileNumbersAreRefusedOrHarmless) {
  const std::vector<std::byte> good = film_bytes(film_of({0, 1, 5, 40}, false));
  constexpr std::size_t kHead = 12 + 3 * 8 + 8 + 1;
  for (std::size_t at = 0; at + 4 <= kHead; ++at) {
    for (std::uint32_t value : {0u, 1u, 2u, 3u, 15u, 16u, 17u, 16384u, 0x7fffffffu, 0xfffffffeu, 0xffffffffu}) {
      std::vector<std::byte> bytes = good;
      std::memcpy(&bytes[at], &value, sizeof value);
      const Result<Film> film = read_film(bytes);
      if (!film.ok()) continue;
      EXPECT_TRUE(film_bytes(*film) == bytes) << at << " " << value;
    }
  }
}

/// Many ranges in a small file must not take long either.
TEST(FilmBytes, ManyRangesAreReadQuickly) {
  std::vector<std::uint32_t> words = {1, 1, 1'000'000};
  for (std::uint32_t i = 0; i < words[2]; ++i) words.insert(words.end(), {32 * i, 32 * i + 1});
  const Result<Film> film = read_film(std::as_bytes(std::span(words)));
  EXPECT_FALSE(film.ok());
  words.insert(words.end(), {0, 0, 0});  // rejected, banded and a little more
  EXPECT_FALSE(read_film(std::as_bytes(std::span(words))).ok());
}

}  // namespace
}  // namespace photond
