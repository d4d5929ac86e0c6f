#include "core/render/settings.h"

#include <gtest/gtest.h>

namespace photond {
namespace {

TEST(Settings, PhotonsGoWithThePixels) {
  const auto photons = [](int width, int height) { return default_photons({.width = width, .height = height}); };
  EXPECT_EQ(photons(1, 1), 1u << 10);
  EXPECT_EQ(photons(30, 30), 1u << 14);
  EXPECT_EQ(photons(128, 128), PhotonSettings{}.photons_per_pass);
  EXPECT_EQ(photons(512, 512), PhotonSettings{}.photons_per_pass);
  EXPECT_EQ(photons(513, 512), 1u << 19);
  EXPECT_EQ(photons(1920, 1080), 1u << 21);
  EXPECT_EQ(photons(16'384, 16'384), 1u << 22);
  EXPECT_EQ(photons(-5, 0), 1u << 10) << "refused elsewhere";
  EXPECT_EQ(default_photons({.method = Method::photon_map, .width = 8, .height = 8}), PhotonSettings{}.photons_per_pass);
}

}  // namespace
}  // namespace photond
