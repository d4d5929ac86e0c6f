#include "core/trace/sheen.h"

#include <gtest/gtest.h>

#include <cmath>

namespace photond {
namespace {

Vec3 direction(float cosine, float azimuth = 0) {
  const float sine = std::sqrt(1 - cosine * cosine);
  return {sine * std::cos(azimuth), sine * std::sin(azimuth), cosine};
}

// ∫ f cos over the hemisphere of white fibres.
double reflected(float roughness, float cosine) {
  constexpr int kHeights = 200, kTurns = 100;
  const Sheen sheen(Rgb(1), roughness, cosine, false);
  double sum = 0;
  for (int i = 0; i < kHeights; ++i) {
    const float root = (static_cast<float>(i) + 0.5f) / kHeights;   // more at grazing angles
    for (int k = 0; k < kTurns; ++k) {
      const float phi = kPi * (static_cast<float>(k) + 0.5f) / kTurns;
      const Vec3 wi = direction(root * root, phi);
      sum += static_cast<double>(sheen.eval(direction(cosine), wi).x * wi.z * 2 * root);
    }
  }
  return sum * 2 * static_cast<double>(kPi) / (kHeights * kTurns);
}

// However smooth, where the fit alone would reflect several times what there is.
TEST(Sheen, ReflectsWhatItDoesNotLetThrough) {
  for (const float roughness : {0.0f, 0.1f, 0.17f, 0.26f, 0.28f, 0.5f, 0.83f, 1.0f}) {
    for (const float cosine : {1e-4f, 0.003f, 0.02f, 0.1f, 0.25f, 0.6f, 1.0f}) {
      const double share = reflected(roughness, cosine);
      const Sheen white(Rgb(1), roughness, cosine, false);
      const double tolerance = cosine < 0.001f ? 0.04 : cosine < 0.01f ? 0.015 : 0.007;
      EXPECT_NEAR(share, 1 - white.through(), tolerance) << roughness << ' ' << cosine;
      EXPECT_LT(share, 1) << roughness << ' ' << cosine;
    }
  }
}

// sin^(1/α) is what makes it: over half of all light at a right angle to the normal, next to nothing along it.
TEST(Sheen, ShinesAtGrazingAngles) {
  for (const float roughness : {0.3f, 0.6f, 1.0f}) {
    EXPECT_GT(reflected(roughness, 0.05f), 0.6);
    EXPECT_LT(reflected(roughness, 1), 0.2);
  }
}

TEST(Sheen, IsTheSameBothWays) {
  for (const float roughness : {0.0f, 0.2f, 0.7f}) {
    for (const float a : {1e-4f, 0.01f, 0.3f, 0.9f}) {
      for (const float b : {2e-4f, 0.05f, 0.6f}) {
        const Vec3 from = direction(a), to = direction(b, 2);
        const float forth = Sheen(Rgb(1), roughness, a, false).eval(from, to).x;
        EXPECT_NEAR(Sheen(Rgb(1), roughness, b, false).eval(to, from).x, forth, 1e-4f * forth);
      }
    }
  }
}

// What its colour reflects most counts for what all colours lose below it.
TEST(Sheen, LetsAllColoursThroughAlike) {
  const Sheen white(Rgb(1), 0.5f, 0.2f, false), red({0.5f, 0.1f, 0}, 0.5f, 0.2f, false);
  EXPECT_NEAR(1 - red.through(), 0.5f * (1 - white.through()), 1e-6f);
  EXPECT_NEAR(red.reflectance().y, 0.1f * white.reflectance().y, 1e-6f);
}

// Masking is given for cosines below ½ and mirrored for those above.
TEST(Sheen, MaskingHasNoStep) {
  for (const float alpha : {0.01f, 0.3f, 1.0f}) {
    const SheenMasking masking(alpha);
    EXPECT_NEAR(masking.lambda(0.4999f) / masking.lambda(0.5001f), 1, 2e-3f);
    EXPECT_GT(masking.lambda(0.1f), masking.lambda(0.4f));
    EXPECT_GT(masking.lambda(0.6f), masking.lambda(1));
  }
}

}  // namespace
}  // namespace photond
