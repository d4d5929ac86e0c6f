#include "core/film/compare.h"

#include <gtest/gtest.h>

#include <cmath>

namespace photond {
namespace {

Image filled(int width, int height, const Rgb& value) {
  Image image(width, height);
  image.pixels.assign(image.pixels.size(), value);
  return image;
}

TEST(Compare, EqualPicturesDifferInNothing) {
  const Image image = filled(16, 16, Rgb(0.5f));
  const Result<Comparison> result = compare_images(image, image);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->mse, 0);
  EXPECT_EQ(result->rel_mse, 0);
  EXPECT_EQ(result->mean_ratio, glm::dvec3(1));
  EXPECT_EQ(result->max_block_deviation, 0);
}

TEST(Compare, KnownDifference) {
  const Result<Comparison> result = compare_images(filled(16, 8, Rgb(1.5f)), filled(16, 8, Rgb(1)));
  ASSERT_TRUE(result.ok());
  EXPECT_NEAR(result->mse, 0.25, 1e-12);
  EXPECT_NEAR(result->rel_mse, 0.25 / 1.01, 1e-12);
  EXPECT_NEAR(result->mean_ratio.y, 1.5, 1e-12);
  EXPECT_NEAR(result->max_block_deviation, 0.5, 1e-6);
  EXPECT_NEAR(result->median_block_deviation, 0.5, 1e-6);
}

TEST(Compare, RelatesDimPicturesToTheirMean) {
  const Result<Comparison> result = compare_images(filled(16, 8, Rgb(0.0015f)), filled(16, 8, Rgb(0.001f)));
  ASSERT_TRUE(result.ok());
  EXPECT_NEAR(result->rel_mse, 0.25 / 2, 1e-6);
  const Result<Comparison> black = compare_images(filled(16, 8, Rgb(0)), filled(16, 8, Rgb(0)));
  ASSERT_TRUE(black.ok());
  EXPECT_EQ(black->rel_mse, 0);
}

TEST(Compare, TrimsTheWorstPerMille) {
  Image image = filled(40, 25, Rgb(1));
  image.at(7, 7) = Rgb(1000);
  const Result<Comparison> result = compare_images(image, filled(40, 25, Rgb(1)));
  ASSERT_TRUE(result.ok());
  EXPECT_GT(result->rel_mse, 900);
  EXPECT_EQ(result->rel_mse_trimmed, 0);
}

TEST(Compare, LooksAtBrightBlocksOnly) {
  Image reference = filled(24, 8, Rgb(1));
  Image image = reference;
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      reference.at(x, y) = Rgb(0.001f);
      image.at(x, y) = Rgb(0.003f);
      image.at(x + 8, y) = Rgb(1.1f);
    }
  }
  const Result<Comparison> result = compare_images(image, reference);
  ASSERT_TRUE(result.ok());
  EXPECT_NEAR(result->max_block_deviation, 0.1, 1e-6);
}

TEST(Compare, BlackChannelsHaveRatioOne) {
  const Result<Comparison> result = compare_images(filled(8, 8, Rgb(1, 0, 1)), filled(8, 8, Rgb(1, 0, 2)));
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->mean_ratio, glm::dvec3(1, 1, 0.5));
}

TEST(Compare, RefusesOtherSizesAndValuesThatAreNotFinite) {
  EXPECT_FALSE(compare_images(filled(8, 8, Rgb(1)), filled(8, 9, Rgb(1))).ok());
  EXPECT_FALSE(compare_images(filled(8, 8, Rgb(std::nanf(""))), filled(8, 8, Rgb(1))).ok());
  EXPECT_FALSE(compare_images(Image(), Image()).ok());
}

}  // namespace
}  // namespace photond
