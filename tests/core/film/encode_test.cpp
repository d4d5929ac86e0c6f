#include "core/film/encode.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/film/decode.h"
#include "core/film/png_chunks.h"

namespace photond {
namespace {

Image gradient() {
  Image image(33, 17);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) image.at(x, y) = {x / 32.0f, y / 16.0f, 1e4f * (x + y)};
  }
  return image;
}

std::vector<std::byte> encoded(const Image& image, ImageFormat format, float exposure = 0) {
  Result<std::vector<std::byte>> bytes = encode(image, format, {exposure});
  EXPECT_TRUE(bytes.ok()) << bytes.error().message;
  return bytes ? *bytes : std::vector<std::byte>{};
}

TEST(Encode, FloatExrKeepsEveryBit) {
  const Image image = gradient();
  const Result<Image> back = decode_exr(encoded(image, ImageFormat::exr_float));
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back->width, image.width);
  EXPECT_EQ(back->height, image.height);
  EXPECT_EQ(back->pixels, image.pixels);
}

TEST(Encode, ThePictureAloneMakesTheFile) {
  Image image(3, 2);
  image.at(1, 1) = Rgb(0.5f);
  for (const ImageFormat format :
       {ImageFormat::png, ImageFormat::jpeg, ImageFormat::exr_half, ImageFormat::exr_half_raw, ImageFormat::exr_float}) {
    const auto bytes = encode(image, format);
    ASSERT_TRUE(bytes.ok());
    const std::string text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    for (const char* century : {"20", "19"}) {
      for (std::size_t at = text.find(century); at != std::string::npos; at = text.find(century, at + 1)) {
        EXPECT_FALSE(at + 4 < text.size() && text[at + 4] == ':') << "a date: " << text.substr(at, 10);
      }
    }
  }
}

TEST(Encode, ANoteIsInTheFileAndChangesNoPixel) {
  const Image image = gradient();
  Image noted = image;
  noted.note = "biased by 7 & more";
  const auto holds = [&](const Result<std::vector<std::byte>>& bytes) {
    EXPECT_TRUE(bytes.ok());
    const std::string text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    return text.find(noted.note) != std::string::npos;
  };
  for (const ImageFormat format : {ImageFormat::png, ImageFormat::jpeg, ImageFormat::exr_half,
                                   ImageFormat::exr_half_raw, ImageFormat::exr_float}) {
    EXPECT_TRUE(holds(encode(noted, format))) << static_cast<int>(format);
    EXPECT_FALSE(holds(encode(image, format)));
  }
  const ErrorLayers error{image, image, image};
  EXPECT_FALSE(holds(encode_exr(image, error)));
  const auto exr = encode_exr(noted, error);
  EXPECT_TRUE(holds(exr));
  EXPECT_EQ(decode_exr(*exr)->pixels, image.pixels);
  EXPECT_EQ(decode_exr(*exr)->note, noted.note) << "for whoever encodes it in another format";
}

TEST(Encode, HalfExrRoundsAndStaysFinite) {
  const Image image = gradient();
  const Result<Image> back = decode_exr(encoded(image, ImageFormat::exr_half));
  ASSERT_TRUE(back.ok()) << back.error().message;
  // A half has 11 significant bits; values beyond its range become the largest.
  EXPECT_NEAR(back->at(5, 0).r, image.at(5, 0).r, image.at(5, 0).r / 2048);
  EXPECT_EQ(back->at(32, 16).b, 65504);
}

// A reference that is one corner of a larger picture, or claims to have 4·10⁹ pixels, is told by its header.
TEST(Encode, OnlyWholePicturesOfFilmsSizesAreRead) {
  const auto window = [](const OIIO::ImageSpec& spec) {
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput proxy(bytes);
    const auto output = OIIO::ImageOutput::create("memory.exr", &proxy);
    EXPECT_TRUE(output->open("memory.exr", spec));
    const std::vector<float> row(static_cast<std::size_t>(spec.width * spec.nchannels));
    for (int y = 0; y < spec.height; ++y) EXPECT_TRUE(output->write_scanline(y, 0, OIIO::TypeFloat, row.data()));
    EXPECT_TRUE(output->close());
    const Result<Image> image = decode_exr(std::as_bytes(std::span(bytes)));
    EXPECT_FALSE(image.ok());
    return image ? std::string() : image.error().message;
  };
  OIIO::ImageSpec part(8, 8, 3, OIIO::TypeFloat);
  part.full_width = 16;
  EXPECT_EQ(window(part), "the picture is a part of one of 16x8 pixels");
  EXPECT_EQ(window(OIIO::ImageSpec(16'385, 1, 3, OIIO::TypeFloat)),
            "the picture has 16385x1 pixels of 3 channels; at most 16384 a side and 64 flat channels are read");
}

TEST(Encode, EndsWhenItIsToldTo) {
  std::stop_source stop;
  stop.request_stop();
  for (const ImageFormat format : {ImageFormat::png, ImageFormat::jpeg, ImageFormat::exr_half, ImageFormat::exr_float}) {
    EXPECT_EQ(encode(gradient(), format, {}, stop.get_token()).error().code, ErrorCode::cancelled);
  }
  const ErrorLayers error{gradient(), gradient(), gradient()};
  EXPECT_EQ(encode_exr(gradient(), error, stop.get_token()).error().code, ErrorCode::cancelled);
}

TEST(Encode, RawExrHoldsTheSameHalves) {
  const auto raw = decode_exr(encoded(gradient(), ImageFormat::exr_half_raw));
  const auto compressed = decode_exr(encoded(gradient(), ImageFormat::exr_half));
  ASSERT_TRUE(raw.ok() && compressed.ok());
  EXPECT_EQ(raw->pixels, compressed->pixels);
}

TEST(Encode, ExrCarriesTheErrorBesideThePicture) {
  const Image image = gradient();
  ErrorLayers error{gradient(), gradient(), gradient()};
  error.noise.at(3, 2) = {0.25f, 0.5f, 1e-9f};
  error.bias.at(3, 2) = {-4, 8, 16};
  error.bound.at(3, 2) = {32, 64, 1e9f};
  const auto bytes = encode_exr(image, error);
  ASSERT_TRUE(bytes.ok()) << bytes.error().message;
  const Result<Image> back = decode_exr(*bytes);
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back->pixels, image.pixels);

  OIIO::Filesystem::IOMemReader reader(const_cast<std::byte*>(bytes->data()), bytes->size());
  const auto input = OIIO::ImageInput::open("memory.exr", nullptr, &reader);
  ASSERT_TRUE(input);
  const OIIO::ImageSpec spec = input->spec();
  EXPECT_EQ(spec.nchannels, 12);
  EXPECT_EQ(spec.format, OIIO::TypeFloat);
  EXPECT_EQ(spec.get_int_attribute("openexr:lineOrder", -1), -1) << "increasing is the default: first row on top";
  std::vector<float> values(image.pixels.size() * 12);
  ASSERT_TRUE(input->read_image(0, 0, 0, 12, OIIO::TypeFloat, values.data()));
  const auto value = [&](const char* channel) {
    return values[image.index(3, 2) * 12 + static_cast<std::size_t>(spec.channelindex(channel))];
  };
  for (const auto& [name, layer] : {std::pair("error.noise", &error.noise), std::pair("error.bias", &error.bias),
                                    std::pair("error.bound", &error.bound)}) {
    const Result<Image> alone = decode_exr(*bytes, name);
    ASSERT_TRUE(alone.ok()) << alone.error().message;
    EXPECT_EQ(alone->pixels, layer->pixels) << name;
  }
  EXPECT_EQ(decode_exr(*bytes, "error.other").error().code, ErrorCode::not_found);
  EXPECT_EQ(Rgb(value("error.noise.R"), value("error.noise.G"), value("error.noise.B")), error.noise.at(3, 2));
  EXPECT_EQ(Rgb(value("error.bias.R"), value("error.bias.G"), value("error.bias.B")), error.bias.at(3, 2));
  EXPECT_EQ(Rgb(value("error.bound.R"), value("error.bound.G"), value("error.bound.B")), error.bound.at(3, 2));

  error.bias = Image(2, 2);
  EXPECT_FALSE(encode_exr(image, error).ok());
}

TEST(Encode, PngIsSrgbWithTheFirstRowOnTop) {
  Image image(3, 2);
  image.pixels = {Rgb(0), Rgb(0.5f), Rgb(7), Rgb(1, 0, 0), Rgb(0.0031308f), Rgb(std::nanf(""))};
  const Result<DecodedPixels> png = decode_pixels(encoded(image, ImageFormat::png));
  ASSERT_TRUE(png.ok()) << png.error().message;
  const std::vector<std::uint8_t> expected = {0,   0, 0, 255, 188, 188, 188, 255, 255, 255, 255, 255,
                                              255, 0, 0, 255, 10,  10,  10,  255, 0,   0,   0,   255};
  EXPECT_EQ(png->u8, expected);
}

TEST(Encode, EveryByteBeginsWhereSrgbRounds) {
  // Values of all sizes, among them the neighbours of those at which a byte begins.
  Image image(1024, 64);
  std::vector<float> values;
  for (int byte = 1; byte < 256; ++byte) {
    const double encoded = (byte - 0.5) / 255;
    const double linear = encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
    float value = static_cast<float>(linear) * (1 - 1e-6f);
    for (int i = 0; i < 40; ++i) values.push_back(value = std::nextafter(value, 2.0f));
  }
  while (values.size() < image.pixels.size()) values.push_back(std::exp2(-20 + 21.0f * static_cast<float>(values.size()) / 65536));
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = Rgb(values[i]);
  const Result<DecodedPixels> png = decode_pixels(encoded(image, ImageFormat::png));
  ASSERT_TRUE(png.ok());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const float v = std::min(values[i], 1.0f);
    const float expected = v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
    ASSERT_EQ(png->u8[4 * i], static_cast<std::uint8_t>(expected * 255 + 0.5f)) << v;
  }
}

TEST(Encode, ExposureDoublesTheLightPerStop) {
  Image image(1, 1);
  image.pixels = {Rgb(0.25f)};
  const Result<DecodedPixels> png = decode_pixels(encoded(image, ImageFormat::png, 1));
  ASSERT_TRUE(png.ok());
  EXPECT_EQ(png->u8[0], 188);
}

TEST(Encode, JpegIsCloseToThePicture) {
  Image image(64, 64);
  image.pixels.assign(image.pixels.size(), Rgb(0.5f, 0.2f, 0.1f));
  const std::vector<std::byte> bytes = encoded(image, ImageFormat::jpeg);
  const Result<DecodedPixels> jpeg = decode_pixels(bytes);
  ASSERT_TRUE(jpeg.ok()) << jpeg.error().message;
  const Result<DecodedPixels> png = decode_pixels(encoded(image, ImageFormat::png));
  ASSERT_TRUE(png.ok());
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(jpeg->u8[c], png->u8[c], 3);
}

TEST(Encode, RefusesAnEmptyPicture) { EXPECT_FALSE(encode(Image(), ImageFormat::png).ok()); }

TEST(Decode, ReadsTheHeaderBeforeThePixels) {
  const std::vector<std::byte> png = encoded(gradient(), ImageFormat::png);
  const Result<DecodedPixels> wide = decode_pixels(png, {.max_side = 32});
  ASSERT_FALSE(wide.ok());
  EXPECT_EQ(wide.error().code, ErrorCode::limit_exceeded);
  EXPECT_EQ(decode_pixels(png, {.max_pixels = 33 * 17 - 1}).error().code, ErrorCode::limit_exceeded);
  EXPECT_TRUE(decode_pixels(png, {.max_side = 33, .max_pixels = 33 * 17}).ok());
}

TEST(Decode, RefusesOtherFormatsAndCorruptFiles) {
  EXPECT_EQ(decode_pixels(encoded(gradient(), ImageFormat::exr_float)).error().code, ErrorCode::unsupported);
  EXPECT_FALSE(decode_pixels({}).ok());
  for (ImageFormat format : {ImageFormat::png, ImageFormat::jpeg}) {
    std::vector<std::byte> bytes = encoded(gradient(), format);
    bytes.resize(16);
    EXPECT_FALSE(decode_pixels(bytes).ok());
  }
  EXPECT_FALSE(decode_exr({}).ok());
  const auto png = encoded(gradient(), ImageFormat::png);
  EXPECT_EQ(decode_exr(png).error().message, "the picture is not OpenEXR");
}

TEST(Decode, DropsPngChunksThatDoNotMakePixels) {
  const std::vector<std::byte> png = encoded(gradient(), ImageFormat::png);
  const Result<std::vector<std::byte>> kept = keep_pixel_chunks(png);
  ASSERT_TRUE(kept.ok());
  EXPECT_LE(kept->size(), png.size());
  // A second time there is nothing left to drop.
  const Result<std::vector<std::byte>> again = keep_pixel_chunks(*kept);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(*again, *kept);
}

}  // namespace
}  // namespace photond
