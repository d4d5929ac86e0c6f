#include "core/film/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <tuple>

#include "core/film/reconstruct.h"
#include "core/math/rng.h"
#include "tests/support/photon_film.h"

namespace photond {
namespace {

using test::mean_square_error;
using test::normal;
using test::PhotonPlane;

using PixelValue = std::function<float(Rng& rng, std::uint32_t pass)>;

/// A film of `passes` passes; each pixel and channel of each pass has a random stream of its own.
Film film_of(int side, std::uint32_t passes, const PixelValue& radiance) {
  Film film(side, side);
  for (std::uint32_t pass = 0; pass < passes; ++pass) {
    PassImage image{.radiance = Image(side, side)};
    for (std::size_t i = 0; i < image.radiance.pixels.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        Rng rng(11, RngPurpose::pilot, pass, 3 * i + static_cast<std::size_t>(c));
        image.radiance.pixels[i][c] = radiance(rng, pass);
      }
    }
    add_pass(film, pass, image);
  }
  return film;
}

/// Share of pixels and channels whose bound contains the distance of the mean from `truth`.
double coverage(const Film& film, float truth) {
  const Image mean = film_picture(film);
  const Image bound = error_layers(film).bound;
  double covered = 0;
  for (std::size_t i = 0; i < mean.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) covered += std::abs(mean.pixels[i][c] - truth) <= bound.pixels[i][c];
  }
  return covered / (3.0 * static_cast<double>(mean.pixels.size()));
}

TEST(StudentT, QuantilesAreThoseOfTheTables) {
  const std::pair<double, double> table[] = {{1, 12.7062}, {2, 4.3027}, {3, 3.1824},  {4, 2.7764},
                                             {7, 2.3646},  {15, 2.1314}, {30, 2.0423}, {1e9, 1.95996}};
  for (const auto& [degrees, quantile] : table) {
    EXPECT_NEAR(t_quantile(degrees), quantile, 0.002 * quantile) << degrees;  // as promised by t_quantile
  }
  const std::pair<double, double> one_sided[] = {{1, 6.3138}, {2, 2.9200}, {3, 2.3534}, {4, 2.1318},
                                                 {7, 1.8946}, {15, 1.7531}, {30, 1.6973}, {1e9, 1.64485}};
  for (const auto& [degrees, quantile] : one_sided) {
    EXPECT_NEAR(t_quantile(degrees, kZ95), quantile, 0.002 * quantile) << degrees;
  }
  // Between whole degrees, by numerical integration of the density.
  const std::tuple<double, double, double> broken[] = {{1.44, 6.3806, 3.8629}, {1.8, 4.7949, 3.1537}, {2.4, 3.6835, 2.6137}};
  for (const auto& [degrees, two_sided, other] : broken) {
    EXPECT_NEAR(t_quantile(degrees), two_sided, 0.02 * two_sided) << degrees;
    EXPECT_NEAR(t_quantile(degrees, kZ95), other, 0.02 * other) << degrees;
  }
}

/// P(|N(bias, 1)| ≤ bound) by the error function.
TEST(ErrorBound, CoversNormalEstimatesOfAnyBias) {
  const auto below = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
  for (double bias = 0; bias < 6; bias += 0.05) {
    const double bound = error_bound(bias, 1, 1e9);
    const double covered = below(bound - bias) - below(-bound - bias);
    EXPECT_GT(covered, 0.945) << bias;   // as promised
    EXPECT_LT(covered, 0.958) << bias;
  }
  EXPECT_EQ(error_bound(0.5, 0, 3), 0.5);
  EXPECT_NEAR(error_bound(0, 2, 3), 2 * 3.1824, 0.01);
  EXPECT_NEAR(error_bound(100, 2, 3), 100 + 2 * 2.3534, 0.01);
}

TEST(ErrorEstimate, NeedsTwoPasses) {
  const auto one = [](Rng&, std::uint32_t) { return 1.0f; };
  EXPECT_FALSE(estimate_error(film_of(2, 1, one)).known);
  EXPECT_TRUE(estimate_error(film_of(2, 2, one)).known);
  EXPECT_EQ(error_layers(film_of(2, 1, one)).bound.pixels[0], Rgb(0));
}

TEST(ErrorEstimate, IsTheStandardErrorOfTheMean) {
  const Film film = film_of(2, 4, [](Rng&, std::uint32_t pass) { return 1.0f + static_cast<float>(pass); });
  // Variance of {1, 2, 3, 4} is 5/3, of the mean 5/12; the mean is 2.5.
  const ErrorEstimate error = estimate_error(film);
  EXPECT_NEAR(error.rmse, std::sqrt(5.0 / 12), 1e-12);
  EXPECT_NEAR(error.relative, std::sqrt(5.0 / 12 / (6.25 + 0.01)), 1e-12);
  EXPECT_EQ(error.bias, 0);
  EXPECT_EQ(error.noise, error.relative);
  EXPECT_NEAR(error_layers(film).noise.pixels[0].x, t_quantile(3) * std::sqrt(5.0 / 12), 1e-6);
}

TEST(ErrorEstimate, EqualPassesHaveNoError) {
  for (std::uint32_t passes : {5u, 64u, 80u}) {
    const ErrorEstimate error = estimate_error(film_of(2, passes, [](Rng&, std::uint32_t) { return 1e4f + 0.1f; }));
    // What remains is the rounding of Σx² − n·mean² in double precision: √(2⁻⁵²) of the value.
    EXPECT_LE(error.rmse, 1e4 * 0x1p-26);
    EXPECT_LE(error.relative, 0x1p-26);
  }
}

/// The true variance of the mean of n passes is 4/n.
TEST(ErrorEstimate, PredictsTheNoiseOfIndependentPasses) {
  const auto value = [](Rng& rng, std::uint32_t) { return 10 + 2 * normal(rng); };
  for (std::uint32_t passes : {8u, 48u, 64u, 160u}) {
    const Film film = film_of(60, passes, value);
    // 10,800 estimates of a variance with at least three degrees of freedom: their mean is known to
    // √(2/3/10,800) = 0.8 %, its root to 0.4 %; four of those.
    EXPECT_NEAR(estimate_error(film).rmse / std::sqrt(4.0 / passes), 1, 0.016) << passes;
    // The share has a standard deviation of √(.05·.95/10,800) = 0.2 %.
    EXPECT_NEAR(coverage(film, 10), 0.95, 0.01) << passes;
  }
}

// As brighter ones; a black one has none.
TEST(ErrorEstimate, OfDimPicturesIsRelativeToThem) {
  const auto relative = [](float scale) {
    return estimate_error(film_of(8, 64, [&](Rng& rng, std::uint32_t) { return scale * rng.next(); })).relative;
  };
  const double dim = relative(0x1p-10f);
  EXPECT_NEAR(dim, relative(0x1p-4f), 1e-9 * dim);
  EXPECT_NEAR(dim, std::sqrt(1.0 / 12 / 64 / (2 * 0.25)), 0.1 * dim);
  EXPECT_EQ(relative(0), 0);
}

// A tenth of the light comes by one sample of 4000: the pixels that it hits are as much too bright as the others are too
// dark, and to relate their error to what they show would hide it.
TEST(ErrorEstimate, PredictsTheErrorOfFireflies) {
  constexpr std::uint32_t kPasses = 32;
  constexpr float kChance = 1 / 4000.0f, kFlash = 400, kRest = 0.9f;
  const float truth = kRest + kChance * kFlash;
  const Film film = film_of(64, kPasses, [&](Rng& rng, std::uint32_t) {
    return rng.next() < kChance ? kRest + kFlash : kRest;
  });
  const double variance = static_cast<double>(kChance * (1 - kChance) * kFlash * kFlash) / kPasses;
  const double expected = std::sqrt(variance / (static_cast<double>(truth * truth) + 0.01));
  double squares = 0;   // of the true error
  for (const Rgb& pixel : film_picture(film).pixels) squares += static_cast<double>(glm::dot(pixel - truth, pixel - truth)) / 3;
  EXPECT_NEAR(std::sqrt(squares / (64 * 64)), std::sqrt(variance), 0.15 * std::sqrt(variance));   // 98 flashes
  // The others show what is left of the light, a tenth less.
  EXPECT_NEAR(estimate_error(film).relative, expected / 0.9, 0.15 * expected);
}

// The edge of a lamp in a dark room, and a picture that is nothing else: what many samples made is as bright as it shows.
TEST(ErrorEstimate, RelatesABrightPixelToItself) {
  constexpr std::uint32_t kPasses = 64;
  for (const int side : {16, 1}) {
    Film film(side, side);
    for (std::uint32_t pass = 0; pass < kPasses; ++pass) {
      PassImage image{.radiance = Image(side, side)};
      image.radiance.pixels[image.radiance.pixels.size() / 2] = Rgb(pass / 16 % 2 == 0 ? 80.0f : 120.0f);
      add_pass(film, pass, image);
    }
    // Four blocks that differ from the mean 100 by 20: V = 4·20²/3/4. The share 4·V/100² = .053
    // of the level is what is around, black.
    const double v = 4.0 * 20 * 20 / 3 / 4, level = side == 1 ? 100 : 100 * (1 - 4 * v / 1e4);
    EXPECT_NEAR(estimate_error(film).relative, std::sqrt(v / (level * level + 0.01) / (side * side)), 1e-6) << side;
  }
}

/// Passes of a block share a random order of 16 strata: the mean of a block has the variance of a 16th of a stratum
/// instead of a 16th of the whole.
TEST(ErrorEstimate, PredictsTheNoiseOfStratifiedBlocks) {
  constexpr int kSide = 60;
  const auto film_of_strata = [](std::uint32_t passes) {
    Film film(kSide, kSide);
    for (std::uint32_t pass = 0; pass < passes; ++pass) {
      PassImage image{.radiance = Image(kSide, kSide)};
      for (std::size_t i = 0; i < image.radiance.pixels.size(); ++i) {
        Rng shift(5, RngPurpose::pilot, pass / kBlockPasses, i);
        Rng within(6, RngPurpose::pilot, pass, i);
        for (int c = 0; c < 3; ++c) {
          const std::uint32_t stratum = (shift.next_uint() + pass) % kBlockPasses;
          image.radiance.pixels[i][c] = (static_cast<float>(stratum) + within.next()) / kBlockPasses;
        }
      }
      add_pass(film, pass, image);
    }
    return film;
  };
  // A uniform stratum of width 1/16 has the variance 1/(12·16²).
  const double truth = std::sqrt(1.0 / 12) / kBlockPasses;
  for (std::uint32_t passes : {32u, 48u, 64u, 160u}) {
    const Film film = film_of_strata(passes);
    // With one degree of freedom each the mean of 10,800 estimates is known to √(2/10,800) = 1.4 %, its root to half
    // of that; four of those.
    EXPECT_NEAR(estimate_error(film).rmse / truth * std::sqrt(passes), 1, 0.028) << passes;
    if (passes >= kBlocksForEstimate * kBlockPasses) {
      EXPECT_NEAR(coverage(film, 0.5f), 0.95, 0.01) << passes;  // as above
    }
  }
  // Before there are two blocks, four for single pixels, the passes are taken for independent: 16 times the truth.
  EXPECT_NEAR(estimate_error(film_of_strata(31)).rmse, std::sqrt(1.0 / 12 / 31), 1e-3);
  EXPECT_GT(coverage(film_of_strata(48), 0.5f), 0.999);
}

/// Windows smear the bias, but neither add to it nor lose any, at borders and where they are larger than the picture.
TEST(ErrorEstimate, CountsABiasAlikeWhereverItIs) {
  for (const int width : {5, 40}) {
    for (const int x : {0, width / 2, width - 1}) {
      Film film(width, 30);
      for (std::uint32_t pass = 0; pass < 2; ++pass) {
        PassImage image{.radiance = Image(width, 30), .bands = std::vector<Bands>(static_cast<std::size_t>(width) * 30)};
        image.bands[static_cast<std::size_t>(x)].value.fill(Rgb(2));   // .73 of the last are the bias
        add_pass(film, pass, image);
      }
      EXPECT_NEAR(estimate_error(film).rmse, 1.46 / std::sqrt(width * 30), 1e-8) << width << " " << x;
    }
  }
}

/// Bands of known sizes without noise are added whole; what the last one says of narrower radii is the bias: .73
/// of it, the geometric mean of a smooth field's third and a step's 1.6.
TEST(ErrorEstimate, ContainsTheBias) {
  Film film(20, 20);
  for (std::uint32_t pass = 0; pass < 4; ++pass) {
    PassImage image{.radiance = Image(20, 20), .bands = std::vector<Bands>(400)};
    for (Rgb& pixel : image.radiance.pixels) pixel = Rgb(8);
    for (Bands& bands : image.bands) bands.value = {Rgb(1), Rgb(0.5f), Rgb(0.25f), Rgb(0.25f)};
    add_pass(film, pass, image);
  }
  const ErrorEstimate error = estimate_error(film);
  EXPECT_NEAR(error.bias, 0.1825 / std::sqrt(100.01), 1e-7);
  EXPECT_EQ(error.noise, 0);
  EXPECT_NEAR(error.rmse, 0.1825, 1e-7);
  const ErrorLayers layers = error_layers(film);
  for (std::size_t i = 0; i < 400; ++i) {
    EXPECT_EQ(film_picture(film).pixels[i], Rgb(10));
    EXPECT_FLOAT_EQ(layers.bias.pixels[i].x, 0.1825f);
    EXPECT_EQ(layers.noise.pixels[i], Rgb(0));
    EXPECT_EQ(layers.bound.pixels[i], layers.bias.pixels[i]);
  }
}

/// On even photons all bands are noise, and little of it may be taken for bias.
TEST(ErrorEstimate, NoiseOfTheBandsIsNoBias) {
  const PhotonPlane plane{.side = 40, .radius = 8};
  double noise = 0, bias = 0;
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const ErrorEstimate error = estimate_error(plane.film(seed, 16));
    noise += error.noise * error.noise;
    bias += error.bias * error.bias;
  }
  // The finest band's energy is 144 times the widest estimate's variance, and all noise.
  EXPECT_LT(bias, noise);
}

TEST(ErrorEstimate, LayersAreAtLeastThePicturesError) {
  const PhotonPlane plane{.side = 24, .radius = 6};
  const Film film = plane.film(1, 8);
  const ErrorEstimate error = estimate_error(film);
  const ErrorLayers layers = error_layers(film);
  double squares = 0;
  for (std::size_t i = 0; i < layers.noise.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const float half_width = layers.noise.pixels[i][c];
      const float bias = layers.bias.pixels[i][c];
      EXPECT_GE(bias, 0);
      EXPECT_GE(layers.bound.pixels[i][c], std::max(half_width, bias) * (1 - 1e-6f));
      EXPECT_LE(layers.bound.pixels[i][c], (half_width + bias) * (1 + 1e-6f));
      // Student's quantiles of any degrees are above the normal one.
      squares += std::pow(static_cast<double>(half_width) / kZ975, 2) + std::pow(static_cast<double>(bias), 2);
    }
  }
  // The layers clamp squared biases at 0 pixel by pixel, the picture in the sum; floats round by 10⁻⁷.
  EXPECT_GE(std::sqrt(squares / (3 * 24 * 24)), error.rmse * (1 - 1e-6));
}

TEST(ErrorEstimate, FlagsPixelsThatHangOnOnePass) {
  const auto firefly = [](Rng& rng, std::uint32_t pass) { return pass == 3 && rng.next() < 0.3f ? 1000.0f : 1.0f; };
  const Film film = film_of(20, 16, firefly);
  const Image mean = film_picture(film);
  const std::vector<bool> flags = dominated_pixels(film);
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    EXPECT_EQ(flags[i], mean.pixels[i].x + mean.pixels[i].y + mean.pixels[i].z > 10);
    count += flags[i];
  }
  EXPECT_GT(count, 0u);
  EXPECT_EQ(estimate_error(film).dominated, count);
}

}  // namespace
}  // namespace photond
