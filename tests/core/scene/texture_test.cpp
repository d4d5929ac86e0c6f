#include "core/scene/texture.h"

#include <gtest/gtest.h>

namespace photond {
namespace {

/// A row of grey texels with the given codes.
Scene row(std::vector<std::uint8_t> codes, Texture texture) {
  TextureImage image{.width = static_cast<int>(codes.size()), .height = 1};
  for (std::uint8_t code : codes) image.u8.insert(image.u8.end(), {code, code, code, 255});
  Scene scene;
  scene.images.push_back(image);
  scene.textures.push_back(texture);
  return scene;
}

float at(const Scene& scene, float u, float v = 0.5f) {
  return sample_texture(scene, scene.textures[0], {u, v}).x;
}

TEST(Texture, InterpolatesBetweenTexelCentres) {
  const Scene scene = row({0, 255}, {.wrap_s = Wrap::clamp});
  EXPECT_FLOAT_EQ(at(scene, 0.25f), 0);
  EXPECT_FLOAT_EQ(at(scene, 0.5f), 0.5f);
  EXPECT_FLOAT_EQ(at(scene, 0.75f), 1);
  EXPECT_FLOAT_EQ(at(scene, 5), 1);
  EXPECT_FLOAT_EQ(at(scene, -5), 0);
}

TEST(Texture, WrapsByRepeatingAndMirroring) {
  const Scene repeat = row({0, 255}, {.wrap_s = Wrap::repeat, .nearest = true});
  EXPECT_FLOAT_EQ(at(repeat, 1.25f), 0);
  EXPECT_FLOAT_EQ(at(repeat, -0.25f), 1);
  const Scene mirror = row({0, 255}, {.wrap_s = Wrap::mirror, .nearest = true});
  EXPECT_FLOAT_EQ(at(mirror, 1.25f), 1);
  EXPECT_FLOAT_EQ(at(mirror, 1.75f), 0);
  EXPECT_FLOAT_EQ(at(mirror, -0.25f), 0);
  // The bilinear neighbour across the seam is the other end.
  EXPECT_FLOAT_EQ(at(row({0, 255}, {}), 0), 0.5f);
}

TEST(Texture, DecodesSrgbBeforeFiltering) {
  // 188 is about half of the light of 255; the mean of 0 and 255 is half the light, not code 128.
  EXPECT_NEAR(at(row({188}, {.srgb = true}), 0.5f), 0.5029f, 1e-4f);
  EXPECT_FLOAT_EQ(at(row({0, 255}, {.wrap_s = Wrap::clamp, .srgb = true}), 0.5f), 0.5f);
  EXPECT_FLOAT_EQ(at(row({128}, {}), 0.5f), 128 / 255.0f);
}

TEST(Texture, ReadsSixteenBits) {
  Scene scene;
  scene.images.push_back({.width = 1, .height = 1, .u16 = {0, 32768, 65535, 13107}});
  scene.textures.push_back({});
  const Vec4 value = sample_texture(scene, scene.textures[0], {0.3f, 0.7f});
  EXPECT_NEAR(glm::length(value - Vec4(0, 0.5f, 1, 0.2f)), 0, 1e-5f);
}

TEST(Texture, FirstRowIsAtTheTop) {
  Scene scene;
  scene.images.push_back({.width = 1, .height = 2, .u8 = {255, 0, 0, 255, 0, 255, 0, 255}});
  scene.textures.push_back({.nearest = true});
  EXPECT_EQ(sample_texture(scene, scene.textures[0], {0.5f, 0.25f}), Vec4(1, 0, 0, 1));
  EXPECT_EQ(sample_texture(scene, scene.textures[0], {0.5f, 0.75f}), Vec4(0, 1, 0, 1));
}

TEST(Texture, SurvivesAnyCoordinate) {
  for (Wrap wrap : {Wrap::repeat, Wrap::clamp, Wrap::mirror}) {
    for (bool nearest : {false, true}) {
      const Scene scene = row({10, 20, 30}, {.wrap_s = wrap, .wrap_t = wrap, .nearest = nearest});
      for (float u : {-1e30f, 1e30f, -1e-30f, 1.0f, std::nextafter(2.0f, 0.0f), kInfinity, std::nanf("")}) {
        const float value = at(scene, u, u);
        EXPECT_GE(value, 10 / 255.0f - 1e-6f);
        EXPECT_LE(value, 30 / 255.0f + 1e-6f);
      }
    }
  }
}

}  // namespace
}  // namespace photond
