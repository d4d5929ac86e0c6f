#include "core/film/film.h"

#include <gtest/gtest.h>

#include <cmath>

namespace photond {
namespace {

Image constant(const Rgb& value) {
  Image image(2, 1);
  image.pixels = {value, value};
  return image;
}

TEST(Film, MeanOfPasses) {
  Film film(2, 1);
  EXPECT_EQ(film_mean(film).pixels[0], Rgb(0));
  add_pass(film, constant(Rgb(1, 2, 3)));
  add_pass(film, constant(Rgb(3, 2, 1)));
  EXPECT_EQ(film.passes, 2u);
  EXPECT_EQ(film_mean(film).pixels[1], Rgb(2));
}

TEST(Film, CountsRejectedSamples) {
  Film film(2, 1);
  Image pass = constant(Rgb(1));
  pass.rejected = 3;
  add_pass(film, pass);
  add_pass(film, pass);
  EXPECT_EQ(film.rejected, 6u);
}

TEST(Film, ErrorNeedsTwoPasses) {
  Film film(2, 1);
  add_pass(film, constant(Rgb(1)));
  EXPECT_FALSE(estimate_error(film).known);
}

TEST(Film, ErrorIsTheStandardErrorOfTheMean) {
  Film film(2, 1);
  for (float value : {1.0f, 2.0f, 3.0f, 4.0f}) add_pass(film, constant(Rgb(value)));
  // Variance of {1, 2, 3, 4} is 5/3, of the mean 5/12; the mean is 2.5.
  const ErrorEstimate error = estimate_error(film);
  ASSERT_TRUE(error.known);
  EXPECT_NEAR(error.rmse, std::sqrt(5.0 / 12), 1e-12);
  EXPECT_NEAR(error.relative, std::sqrt(5.0 / 12 / (6.25 + 0.01)), 1e-12);
}

TEST(Film, EqualPassesHaveNoError) {
  Film film(2, 1);
  for (int i = 0; i < 5; ++i) add_pass(film, constant(Rgb(0.1f, 1e4f, 0)));
  // What remains is the rounding of double sums.
  EXPECT_NEAR(estimate_error(film).rmse, 0, 1e-3);
  EXPECT_NEAR(estimate_error(film).relative, 0, 1e-7);
}

}  // namespace
}  // namespace photond
