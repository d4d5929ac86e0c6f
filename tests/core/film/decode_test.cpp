#include "core/film/decode.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/film/encode.h"

namespace photond {
namespace {

/// A grey JPEG whose scan is in it `times` times.
std::vector<std::byte> jpeg_of_scans(int times) {
  Image grey(8, 8);
  std::ranges::fill(grey.pixels, Rgb(0.5f));
  const std::vector<std::byte> jpeg = *encode(grey, ImageFormat::jpeg);
  constexpr std::byte kStartOfScan[] = {std::byte{0xFF}, std::byte{0xDA}};
  const auto scan = std::search(jpeg.begin(), jpeg.end(), std::begin(kStartOfScan), std::end(kStartOfScan));
  const auto end = jpeg.end() - 2;
  std::vector<std::byte> out(jpeg.begin(), scan);
  for (int i = 0; i < times; ++i) out.insert(out.end(), scan, end);
  out.insert(out.end(), end, jpeg.end());
  return out;
}

TEST(Decode, ReadsAJpegOfAFewScans) {
  for (int scans : {1, 10}) {
    const Result<DecodedPixels> pixels = decode_pixels(jpeg_of_scans(scans));
    ASSERT_TRUE(pixels.ok()) << pixels.error().message;
    EXPECT_EQ(pixels->width, 8);
    EXPECT_EQ(pixels->u8.size(), 4u * 8 * 8);
  }
}

// Each takes as long as all pixels, however few bytes it has.
TEST(Decode, RefusesAJpegOfVeryManyScans) {
  const Result<DecodedPixels> pixels = decode_pixels(jpeg_of_scans(1000));
  ASSERT_FALSE(pixels.ok());
  EXPECT_EQ(pixels.error().code, ErrorCode::limit_exceeded);
}

}  // namespace
}  // namespace photond
