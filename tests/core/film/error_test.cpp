#include "core/film/error.h"

#include "core/film/reconstruct.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/math/rng.h"

namespace photond {
namespace {

/// Normally distributed by Box and Muller, mean 0, variance 1.
float normal(Rng& rng) {
  const float radius = std::sqrt(-2 * std::log(1 - rng.next()));
  return radius * std::cos(2 * kPi * rng.next());
}

using PixelValue = std::function<float(Rng& rng, std::uint32_t pass)>;

/// A film of `passes` passes; each pixel and channel of each pass has a random stream of its own.
Film film_of(int side, std::uint32_t passes, const PixelValue& radiance, const PixelValue& bias = {}) {
  Film film(side, side);
  for (std::uint32_t pass = 0; pass < passes; ++pass) {
    PassImage image{.radiance = Image(side, side), .bias = {}};
    if (bias) image.bias = Image(side, side);
    for (std::size_t i = 0; i < image.radiance.pixels.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        Rng rng(11, RngPurpose::pilot, pass, 3 * i + static_cast<std::size_t>(c));
        image.radiance.pixels[i][c] = radiance(rng, pass);
        if (bias) image.bias.pixels[i][c] = bias(rng, pass);
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

/// Passes of a block share a random order of 16 strata: the mean of a block has the variance of a 16th of a stratum
/// instead of a 16th of the whole.
TEST(ErrorEstimate, PredictsTheNoiseOfStratifiedBlocks) {
  constexpr int kSide = 60;
  const auto film_of_strata = [](std::uint32_t passes) {
    Film film(kSide, kSide);
    for (std::uint32_t pass = 0; pass < passes; ++pass) {
      PassImage image{.radiance = Image(kSide, kSide), .bias = {}};
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
  for (std::uint32_t passes : {64u, 160u}) {
    const Film film = film_of_strata(passes);
    // A uniform stratum of width 1/16 has the variance 1/(12·16²).
    const double truth = std::sqrt(1.0 / 12) / kBlockPasses / std::sqrt(passes);
    EXPECT_NEAR(estimate_error(film).rmse / truth, 1, 0.016) << passes;  // as above
    EXPECT_NEAR(coverage(film, 0.5f), 0.95, 0.01) << passes;
  }
  // Before there are four blocks the estimate takes the passes for independent: 16 times the truth.
  EXPECT_NEAR(estimate_error(film_of_strata(48)).rmse, std::sqrt(1.0 / 12 / 48), 1e-3);
  EXPECT_GT(coverage(film_of_strata(48), 0.5f), 0.999);
}

TEST(ErrorEstimate, ContainsTheBias) {
  // The passes are 0.5 too large, and say so with a noise of 4 per pass.
  const Film film = film_of(
      60, 256, [](Rng& rng, std::uint32_t) { return 10.5f + normal(rng); },
      [](Rng& rng, std::uint32_t) { return 0.5f + 4 * normal(rng); });
  const ErrorEstimate error = estimate_error(film);
  // Noise of b, smoothed over 25 pixels: 4/√(256·25) = .05, of b² averaged over 432 windows: 2·.5·.05/√432 = .0024.
  EXPECT_NEAR(error.bias, 0.5 / std::sqrt(10.5 * 10.5 + 0.01), 4 * 0.0024 / 10.5);
  EXPECT_NEAR(error.noise, 1 / 16.0 / 10.5, 0.016 / 16 / 10.5);
  EXPECT_NEAR(error.relative, std::hypot(error.noise, error.bias), 1e-12);
  EXPECT_NEAR(error.rmse, std::hypot(0.5, 1.0 / 16), 0.01);
  const ErrorLayers layers = error_layers(film);
  // The worst window is a corner of 3×3 pixels with a noise of 4/√(256·9) = .083; 4.5 σ of 10,800.
  for (const Rgb& b : layers.bias.pixels) EXPECT_NEAR(b.x, 0.5, 4.5 * 0.083);
  // The bound t·σ + |b| with a noisy b is passed by chance 1 − Φ(1.97·σ/√(σ² + .05²)) = 6.2 %, σ = 1/16; more at the
  // edges, where b is noisier.
  EXPECT_NEAR(coverage(film, 10), 0.938, 0.01);
}

TEST(ErrorEstimate, ANoisyEstimateOfNoBiasIsNoBias) {
  const auto radiance = [](Rng& rng, std::uint32_t) { return 10 + normal(rng); };
  const auto noise = [](Rng& rng, std::uint32_t) { return 8 * normal(rng); };
  for (std::uint32_t passes : {2u, 9u, 64u}) {
    const Film film = film_of(60, passes, radiance, noise);
    // b has the standard deviation 8/√(25 n); the square of one mean would report it as bias. The mean of
    // b_even·b_odd over 432 windows is 0 within 2·64/(25 n)/√432, its root under a quarter of that of b² (σ ≈ .31
    // at one σ; 4.1 σ of a root is at .63).
    EXPECT_LE(estimate_error(film).bias * 10, 0.63 * 8 / std::sqrt(25.0 * passes)) << passes;
  }
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
