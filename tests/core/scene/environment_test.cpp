#include "core/scene/environment.h"

#include <gmock/gmock.h>

#include <cstring>

#include "core/film/encode.h"
#include "core/math/rng.h"
#include "core/math/warp.h"
#include "core/scene/scene.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

using testing::Contains;
using testing::HasSubstr;

EnvironmentMap noise(int width, int height) {
  Rng rng(3, RngPurpose::pilot, 0, 0);
  std::vector<Rgb> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (Rgb& pixel : pixels) pixel = {rng.next(), rng.next() * rng.next(), rng.next()};
  return {width, height, std::move(pixels)};
}

// A dim sky with one texel a million times as bright, half of it black.
EnvironmentMap sun() {
  std::vector<Rgb> pixels(24 * 12, Rgb(0.01f));
  std::fill(pixels.begin() + 24 * 7, pixels.end(), Rgb(0));
  pixels[24 * 3 + 5] = Rgb(1e4f);
  return {24, 12, std::move(pixels)};
}

std::vector<EnvironmentMap> maps() {
  std::vector<EnvironmentMap> all;
  all.push_back(noise(24, 12));
  all.push_back(sun());
  all.push_back(noise(1, 1));
  all.push_back(noise(2, 1));
  all.push_back(noise(1, 3));
  return all;
}

// The statistics stand on z, the map on y.
Vec3 upright(const Vec3& w) { return {w.y, w.z, w.x}; }
Vec3 lying(const Vec3& w) { return {w.z, w.x, w.y}; }

// Mean over directions by a midpoint rule in longitude and height, each exact to the jumps' share of its cells.
double mean_over_sphere(const std::function<double(const Vec3&)>& f) {
  constexpr int kColumns = 480, kRows = 500;
  double sum = 0;
  for (int y = 0; y < kRows; ++y) {
    const double z = (y + 0.5) / kRows * 2 - 1, r = std::sqrt(1 - z * z);
    for (int x = 0; x < kColumns; ++x) {
      const double phi = (x + 0.5) / kColumns * 2 * std::numbers::pi;
      sum += f(Vec3(r * std::cos(phi), z, r * std::sin(phi)));
    }
  }
  return sum / (kColumns * kRows);
}

TEST(EnvironmentMap, DirectionsMatchTheirPdf) {
  // Cells of the maps are whole cells of the histogram or halves of them.
  for (const EnvironmentMap& map : maps()) {
    EXPECT_GT(test::chi2_sphere([&](Rng& rng) { return lying(map.sample(rng.next2()).wi); },
                                [&](const Vec3& w) { return static_cast<double>(map.pdf(upright(w))); }),
              test::kSignificance)
        << map.width() << " x " << map.height();
  }
}

TEST(EnvironmentMap, PdfIntegratesToOne) {
  for (const EnvironmentMap& map : maps()) {
    const double mean = mean_over_sphere([&](const Vec3& w) { return static_cast<double>(map.pdf(w)); });
    // A row of directions may lie on the wrong side of a border: 2/500 of the row's density, which differs from its
    // neighbour's by its own size where a sun is.
    EXPECT_NEAR(mean * 4 * std::numbers::pi, 1, 0.02) << map.width() << " x " << map.height();
  }
  const EnvironmentMap even(24, 12, std::vector<Rgb>(24 * 12, Rgb(3)));
  EXPECT_NEAR(even.mean(), 3, 1e-6);
  EXPECT_NEAR(even.concentration(), 1, 1e-6);
  // Thousands of cells of a probability of 10⁻⁵, each rounded to 2⁻²⁴.
  for (const Vec3& w : {Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(1, 0, 0), Vec3(0, 0, -1)}) {
    EXPECT_NEAR(even.pdf(w), kSpherePdf, kSpherePdf * 1e-3);
  }
}

TEST(EnvironmentMap, SamplesTellWhatLookupsTell) {
  for (const EnvironmentMap& map : maps()) {
    Rng rng(5, RngPurpose::pilot, 0, 0);
    int differ = 0;
    for (int i = 0; i < 20'000; ++i) {
      const EnvironmentSample s = map.sample(rng.next2());
      ASSERT_NEAR(glm::length(s.wi), 1, 1e-6);
      ASSERT_GT(s.pdf_w, 0);
      const float brightest = max_component(s.radiance);
      // Rounding of the direction: 10⁻⁶ of a turn, times 24 texels, times a step to the brightest neighbour.
      const bool same = std::abs(map.pdf(s.wi) - s.pdf_w) <= 1e-5f * s.pdf_w &&
                        max_component(glm::abs(map.radiance(s.wi) - s.radiance)) <= 1e-3f * brightest + 1e-2f;
      differ += same ? 0 : 1;
    }
    // Directions within rounding of a border.
    EXPECT_LE(differ, 20) << map.width() << " x " << map.height();
  }
}

// Of four corners one may be the only lit one, of three channels, too; a twentieth of the choices ignores radiance.
TEST(EnvironmentMap, RadianceOverDensityIsBounded) {
  for (const EnvironmentMap& map : maps()) {
    const double bound = 12 * 4 * std::numbers::pi * map.mean() * 1.05;
    Rng rng(5, RngPurpose::pilot, 0, 0);
    test::Sample mean;
    for (int i = 0; i < 100'000; ++i) {
      const EnvironmentSample s = map.sample(rng.next2());
      ASSERT_LE(static_cast<double>(max_component(s.radiance) / s.pdf_w), bound * 1.001);
      mean.add(static_cast<double>(s.radiance.x + s.radiance.y + s.radiance.z) / 3 / static_cast<double>(s.pdf_w));
    }
    const double exact = mean_over_sphere([&](const Vec3& w) {
      const Rgb c = map.radiance(w);
      return static_cast<double>(c.x + c.y + c.z) / 3;
    });
    // The midpoint rule's own error where a sun's texel is a hundred directions wide: 10⁻³.
    EXPECT_NEAR(mean.mean, exact * 4 * std::numbers::pi,
                test::kSigmas * mean.standard_error() + 2e-3 * exact * 4 * std::numbers::pi);
  }
}

TEST(EnvironmentMap, LooksWhereThePictureSays) {
  // Columns from left to right: centre +X, a quarter to the right +Z, to the left −Z, the seam −X.
  std::vector<Rgb> pixels(8 * 4, Rgb(0));
  pixels[8 * 1 + 4] = {1, 0, 0};
  pixels[8 * 1 + 6] = {0, 1, 0};
  pixels[8 * 1 + 0] = {0, 0, 1};
  const EnvironmentMap map(8, 4, pixels);
  // The centre of texel (x, y).
  const auto towards = [](int x, int y) {
    const float theta = (static_cast<float>(y) + 0.5f) / 4 * kPi, phi = ((static_cast<float>(x) + 0.5f) / 8 - 0.5f) * 2 * kPi;
    return Vec3(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
  };
  EXPECT_GT(towards(4, 1).x, 0.5f);
  EXPECT_GT(towards(6, 1).z, 0.5f);
  EXPECT_LT(towards(0, 1).x, -0.5f);
  for (const int x : {0, 4, 6}) {
    EXPECT_LT(max_component(glm::abs(map.radiance(towards(x, 1)) - pixels[8 + static_cast<std::size_t>(x)])), 1e-5f);
  }
  // Halfway to a black neighbour, across the seam, too.
  const Vec3 seam = glm::normalize(towards(0, 1) + towards(7, 1));
  EXPECT_NEAR(map.radiance(seam).z, 0.5f, 0.02f);
}

TEST(Environment, TurnsAboutTheVertical) {
  std::vector<Rgb> pixels(8 * 4, Rgb(0));
  for (std::size_t y = 0; y < 4; ++y) pixels[8 * y + 3] = pixels[8 * y + 4] = Rgb(1);   // around +X
  Environment environment;
  environment.radiance = {2, 4, 8};
  environment.map = std::make_shared<EnvironmentMap>(8, 4, pixels);
  EXPECT_EQ(environment.from({1, 0, 0}), Rgb(2, 4, 8));
  environment.rotation = kPi / 2;
  EXPECT_LT(glm::distance(environment.from({0, 0, -1}), Rgb(2, 4, 8)), 1e-4f);
  EXPECT_EQ(environment.from({1, 0, 0}), Rgb(0));
  Rng rng(5, RngPurpose::pilot, 0, 0);
  int differ = 0;
  for (int i = 0; i < 1000; ++i) {
    const EnvironmentSample s = environment.sample(rng.next2());
    EXPECT_LT(s.wi.z, 0);
    differ += std::abs(environment.pdf_w(s.wi) - s.pdf_w) > 1e-4f * s.pdf_w;
    EXPECT_NEAR(s.radiance.y, 2 * s.radiance.x, 1e-5f);
  }
  EXPECT_LE(differ, 2);
}

TEST(Environment, ReplacesAnAssumedOne) {
  Scene scene;
  scene.warnings = {"cameras: none", std::string("lights: ") + kNoLightWarning};
  auto map = std::make_shared<EnvironmentMap>(1, 1, std::vector<Rgb>{Rgb(1)});
  map->warnings = {"environment: odd"};
  Environment environment{.radiance = Rgb(2), .map = map, .rotation = 1};
  const Digest without = scene_digest(scene);
  set_environment(scene, environment);
  EXPECT_THAT(scene.warnings, testing::ElementsAre("cameras: none", "environment: odd"));
  const Digest with = scene_digest(scene);
  EXPECT_NE(with, without);
  scene.environment.rotation = 2;
  EXPECT_NE(scene_digest(scene), with);
  scene.environment = environment;
  scene.environment.radiance = Rgb(3);
  EXPECT_NE(scene_digest(scene), with);
  scene.environment = environment;
  scene.environment.map = std::make_shared<EnvironmentMap>(1, 1, std::vector<Rgb>{Rgb(1.5f)});
  EXPECT_NE(scene_digest(scene), with);
}

// What files say.

std::vector<std::byte> exr(const Image& image, ImageFormat format = ImageFormat::exr_float) {
  const auto bytes = encode(image, format);
  EXPECT_TRUE(bytes.ok());
  return bytes ? *bytes : std::vector<std::byte>{};
}

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// Two pixels of Radiance RGBE: value = mantissa/256 · 2^(exponent − 128).
std::string hdr() {
  return std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n") + std::string("\x80\x40\x20\x81\xff\x00\x80\x84", 8);
}

TEST(ReadEnvironment, ReadsExrAndHdr) {
  Image image(4, 2);
  for (std::size_t i = 0; i < 8; ++i) image.pixels[i] = {static_cast<float>(i), 1, 100.5f};
  for (const ImageFormat format : {ImageFormat::exr_float, ImageFormat::exr_half}) {
    const auto map = read_environment(exr(image, format));
    ASSERT_TRUE(map.ok()) << map.error().message;
    EXPECT_EQ((*map)->digest(), EnvironmentMap(4, 2, image.pixels).digest());
    EXPECT_TRUE((*map)->warnings.empty());
  }
  const auto map = read_environment(bytes_of(hdr()));
  ASSERT_TRUE(map.ok()) << map.error().message;
  EXPECT_EQ((*map)->width(), 2);
  EXPECT_EQ((*map)->height(), 1);
  // Read with or without the half step that the format's mantissas may be taken to have.
  EXPECT_NEAR((*map)->mean(), ((1 + 0.5 + 0.25) + (16 + 0 + 8)) / 6, 0.06);
}

TEST(ReadEnvironment, ClampsNegativeValuesAndSaysSo) {
  Image image(2, 1);
  image.pixels = {{1, -2, 3}, {-1, 5, 6}};
  const auto map = read_environment(exr(image));
  ASSERT_TRUE(map.ok());
  EXPECT_THAT((*map)->warnings, Contains(HasSubstr("2 negative")));
  EXPECT_NEAR((*map)->mean(), 2.5, 1e-6);
  const auto black = read_environment(exr(Image(2, 1)));
  ASSERT_TRUE(black.ok());
  EXPECT_THAT((*black)->warnings, Contains(HasSubstr("black")));
  Environment environment{.radiance = Rgb(1), .map = *black};
  EXPECT_FALSE(environment.active());
}

TEST(ReadEnvironment, RefusesWhatIsNoNumber) {
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), kInfinity, -kInfinity, 1e35f}) {
    Image image(3, 2);
    image.at(1, 1).y = value;
    const auto map = read_environment(exr(image));
    ASSERT_FALSE(map.ok());
    EXPECT_EQ(map.error().code, ErrorCode::invalid_input);
    EXPECT_THAT(map.error().message, HasSubstr("pixel (1, 1)"));
  }
}

TEST(ReadEnvironment, ComparesLimitsWithTheHeader) {
  const auto bytes = exr(Image(40, 20));
  const auto wide = read_environment(bytes, {.max_side = 39});
  ASSERT_FALSE(wide.ok());
  EXPECT_EQ(wide.error().code, ErrorCode::limit_exceeded);
  EXPECT_FALSE(read_environment(bytes, {.max_pixels = 799}).ok());
  EXPECT_TRUE(read_environment(bytes, {.max_side = 40, .max_pixels = 800}).ok());
  // A header of a million columns, and no pixels: refused by its size, not for what is missing.
  const auto huge = read_environment(bytes_of("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000 +X 1000000\n"));
  ASSERT_FALSE(huge.ok());
  EXPECT_EQ(huge.error().code, ErrorCode::limit_exceeded) << huge.error().message;
}

TEST(ReadEnvironment, RefusesOtherFormats) {
  const auto png = encode(Image(4, 4), ImageFormat::png);
  for (const auto& bytes : {*png, bytes_of(""), bytes_of("#"), bytes_of("{\"asset\":{}}")}) {
    const auto map = read_environment(bytes);
    ASSERT_FALSE(map.ok());
    EXPECT_EQ(map.error().code, ErrorCode::unsupported);
  }
}

// The line of the size tells where its first pixel lies. Read as if that were the upper left, a sky would be below.
TEST(ReadEnvironment, RefusesPicturesThatAreStoredTurned) {
  for (const char* size : {"+Y 1 +X 2", "-Y 1 -X 2", "+Y 1 -X 2", "+X 2 -Y 1"}) {
    std::string turned = hdr();
    turned.replace(turned.find("-Y"), 9, size);
    const auto map = read_environment(bytes_of(turned));
    ASSERT_FALSE(map.ok()) << size;
    EXPECT_EQ(map.error().code, ErrorCode::unsupported) << size;
    EXPECT_THAT(map.error().message, HasSubstr("turned")) << size;
  }
}

// Cut anywhere, or with any byte changed, a file is refused or read, and nothing else happens.
TEST(ReadEnvironment, SurvivesDamagedFiles) {
  Image image(16, 8);
  Rng random(9, RngPurpose::pilot, 0, 0);
  for (Rgb& pixel : image.pixels) pixel = {random.next(), random.next(), random.next()};
  const EnvironmentLimits limits{.max_side = 256, .max_pixels = 4096};
  for (const auto& bytes : {exr(image), exr(image, ImageFormat::exr_half), bytes_of(hdr())}) {
    for (std::size_t size = 0; size < bytes.size(); size += 1 + bytes.size() / 40) {
      EXPECT_FALSE(read_environment(std::span(bytes).first(size), limits).ok()) << size;
    }
    for (int i = 0; i < 150; ++i) {
      auto damaged = bytes;
      for (int k = 0; k < 1 + i % 3; ++k) {
        damaged[random.next_uint() % std::min<std::size_t>(damaged.size(), i % 2 ? damaged.size() : 400)] =
            static_cast<std::byte>(random.next_uint());
      }
      const auto map = read_environment(damaged, limits);
      EXPECT_TRUE(!map || std::isfinite((*map)->mean()));
    }
  }
}

}  // namespace
}  // namespace photond
