// Pictures of photons on a plane, whose densities are known.
#include "core/film/reconstruct.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/film/error.h"
#include "tests/support/photon_film.h"

namespace photond {
namespace {

using test::mean_square_error;
using test::PhotonPlane;

constexpr int kSide = 40;

double step(double x, double) { return x < 20.3 ? 1.0 : 0.2; }
double waves(double x, double y) { return 0.5 + 0.4 * std::sin(x / 9) * std::cos(y / 7); }

Image widest(const Film& film) {
  Image image(film.width, film.height);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = Rgb(pass_mean(film, i));
  return image;
}

/// The estimate of the narrowest radius: all bands added.
Image narrowest(const Film& film) {
  Image image = widest(film);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    for (int j = 0; j < kBands; ++j) {
      for (int c = 0; c < 3; ++c) {
        image.pixels[i][c] += static_cast<float>(film.bands[i].value[j][c].value() / film.pass_count());
      }
    }
  }
  return image;
}

TEST(Reconstruct, WithoutBandsIsTheMeanOfThePasses) {
  Film film(2, 1);
  PassImage pass{.radiance = Image(2, 1)};
  pass.radiance.pixels = {Rgb(1, 2, 3), Rgb(4)};
  add_pass(film, 0, pass);
  const Reconstruction picture = reconstruct(film);
  EXPECT_EQ(picture.mean[0], glm::dvec3(1, 2, 3));
  EXPECT_EQ(picture.variance[1], glm::dvec3(0));
  EXPECT_EQ(picture.bias_sq[1], glm::dvec3(0));
}

TEST(Reconstruct, OfNoPassesIsBlack) {
  EXPECT_EQ(film_picture(Film(2, 2)).pixels[3], Rgb(0));
}

TEST(Reconstruct, LeavesNoiseOut) {
  const PhotonPlane plane{.side = kSide, .radius = 8};
  double picture = 0, wide = 0, narrow = 0;
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
    const Film film = plane.film(seed, 16);
    picture += mean_square_error(film_picture(film), plane);
    wide += mean_square_error(widest(film), plane);
    narrow += mean_square_error(narrowest(film), plane);
  }
  // The narrowest radius has 4⁴ = 256 times the widest one's variance. Where energies of few independent values
  // come out at twice the noise by chance some of it is added: less than half of the least variance.
  EXPECT_LT(picture, 1.5 * wide);
  EXPECT_GT(narrow, 100 * picture);
}

TEST(Reconstruct, AddsWhatIsSignal) {
  for (const auto& density : {step, waves}) {
    const PhotonPlane plane{.side = kSide, .radius = 12, .density = density};
    const Film film = plane.film(1, 32);
    const double picture = mean_square_error(film_picture(film), plane);
    // Better than half of what either extreme gives.
    EXPECT_LT(picture, 0.5 * mean_square_error(widest(film), plane));
    EXPECT_LT(picture, 0.5 * mean_square_error(narrowest(film), plane));
  }
}

TEST(Reconstruct, ConvergesWhereTheWidestRadiusDoesNot) {
  const PhotonPlane plane{.side = kSide, .radius = 12, .density = waves};
  Film film(kSide, kSide);
  double before = 1e30;
  for (std::uint32_t pass = 0; pass < 128; ++pass) {
    add_pass(film, pass, plane.pass(5, pass));
    if (pass + 1 != 8 && pass + 1 != 32 && pass + 1 != 128) continue;
    const double error = mean_square_error(film_picture(film), plane);
    // Four times the passes halve a Monte Carlo error; of a density with bias n^(−2/3) is left of its square: 0.4.
    EXPECT_LT(error, 0.6 * before) << pass + 1;
    before = error;
  }
}

// A lamp of a billionth and one of a billion times the power give the same picture but for that: what is noise is told by
// squares, whose range is twice as wide.
TEST(Reconstruct, IsTheSamePictureAtAnyPower) {
  const PhotonPlane plane{.side = kSide, .radius = 12, .density = step};
  const auto picture = [&](float power) {
    Film film(kSide, kSide);
    for (std::uint32_t p = 0; p < 4; ++p) {
      PassImage pass = plane.pass(6, p);
      for (Rgb& pixel : pass.radiance.pixels) pixel *= power;
      for (Bands& bands : pass.bands) {
        for (Rgb& value : bands.value) value *= power;
        for (float& variance : bands.variance) variance *= power * power;
      }
      add_pass(film, p, pass);
    }
    EXPECT_EQ(film.rejected, 0u);
    return film_picture(film);
  };
  const Image one = picture(1);
  for (const float power : {0x1p-30f, 0x1p30f}) {
    const Image other = picture(power);
    for (std::size_t i = 0; i < one.pixels.size(); ++i) ASSERT_NEAR(other.pixels[i].x / power, one.pixels[i].x, 1e-4f);
  }
}

/// Bands without noise are added whole wherever they hold anything.
TEST(Reconstruct, SharesAreOneWithoutNoise) {
  Film film(16, 16);
  PassImage pass{.radiance = Image(16, 16), .bands = std::vector<Bands>(256)};
  for (std::size_t i = 0; i < 256; ++i) {
    pass.radiance.pixels[i] = Rgb(4);
    for (int j = 0; j < kBands; ++j) pass.bands[i].value[j] = Rgb(i % 3 == 0 ? 0.5f : -0.25f);
  }
  add_pass(film, 0, pass);
  const Image picture = film_picture(film);
  for (std::size_t i = 0; i < 256; ++i) EXPECT_EQ(picture.pixels[i], Rgb(i % 3 == 0 ? 6.0f : 3.0f));
}

/// A mixture of estimates that are not negative is not negative.
TEST(Reconstruct, IsNeverNegative) {
  const PhotonPlane plane{.side = kSide, .radius = 12, .photons = 20, .density = [](double x, double y) {
                            return x < 12 || (y > 30 && x > 30) ? 1.0 : 0.0;
                          }};
  for (const std::uint32_t passes : {1u, 4u, 16u}) {
    // Sums of floats cancel to a rounding of the kernels' heights.
    for (const Rgb& pixel : film_picture(plane.film(2, passes)).pixels) EXPECT_GE(pixel.x, -1e-4f);
  }
}

// Where nothing gathers photons, as in the sky beside a bright floor, no error is told, and the floor's keeps its size.
TEST(Reconstruct, TellsNoErrorWhereNothingIsGathered) {
  const PhotonPlane plane{.side = kSide, .radius = 12, .density = step};
  constexpr std::size_t kBorder = 25;   // near a step: there are noise and bias
  Film half(kSide, kSide), whole(kSide, kSide);
  for (std::uint32_t p = 0; p < 32; ++p) {
    PassImage pass = plane.pass(3, p);
    add_pass(whole, p, pass);
    for (std::size_t i = 0; i < pass.bands.size(); ++i) {
      if (i % kSide < kBorder) continue;
      pass.radiance.pixels[i] = Rgb(0);
      pass.bands[i] = {};
    }
    add_pass(half, p, pass);
  }
  const Reconstruction beside = reconstruct(half), all = reconstruct(whole);
  double noise = 0, of_whole = 0, bias = 0, bias_of_whole = 0;
  for (std::size_t i = 0; i < kSide * kSide; ++i) {
    const std::size_t x = i % kSide;
    if (x >= kBorder) {
      ASSERT_EQ(beside.variance[i], glm::dvec3(0));
      ASSERT_EQ(beside.bias_sq[i], glm::dvec3(0));
    } else if (x >= kBorder - 8) {   // where windows reach over the border
      noise += beside.variance[i].x, of_whole += all.variance[i].x;
      bias += beside.bias_sq[i].x, bias_of_whole += all.bias_sq[i].x;
    }
  }
  EXPECT_GT(of_whole, 0);
  EXPECT_NEAR(noise, of_whole, 0.2 * of_whole);
  EXPECT_GT(bias_of_whole, 0);
  EXPECT_NEAR(bias, bias_of_whole, 0.5 * bias_of_whole);   // the step has more of a window that ends with the floor
}

/// Predicted against true mean square errors, over seeds.
TEST(ReconstructStatistical, KnowsItsError) {
  constexpr std::uint64_t kSeeds = 20;
  const auto spot = [](double x, double y) {
    return 0.1 + 4 * std::exp(-((x - 18) * (x - 18) + (y - 22) * (y - 22)) / 18);
  };
  for (const PhotonPlane& plane :
       {PhotonPlane{.side = 48, .radius = 10, .density = step}, PhotonPlane{.side = 48, .radius = 10, .density = waves},
        PhotonPlane{.side = 48, .radius = 10, .density = spot, .highest = 4.2}}) {
    for (const std::uint32_t passes : {16u, 64u}) {
      double predicted = 0, truth = 0, covered = 0;
      for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        const Film film = plane.film(seed, passes);
        const Image picture = film_picture(film);
        const ErrorEstimate error = estimate_error(film);
        const ErrorLayers layers = error_layers(film);
        predicted += error.rmse * error.rmse;
        truth += mean_square_error(picture, plane);
        for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
          covered += std::abs(static_cast<double>(picture.pixels[i].x) - plane.truth(i)) <=
                     static_cast<double>(layers.bound.pixels[i].x);
        }
      }
      // What the bands beyond the added ones hold is a guess between a step's and a smooth field's, and its window
      // smears the bias of small spots.
      EXPECT_GT(predicted, 0.75 * truth) << passes;
      EXPECT_LT(predicted, 1.8 * truth) << passes;
      EXPECT_GT(covered / (kSeeds * 48.0 * 48), 0.92) << passes;
      EXPECT_LT(covered / (kSeeds * 48.0 * 48), 0.99) << passes;
    }
  }
}

}  // namespace
}  // namespace photond
