#include "core/film/encode.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <string_view>

namespace photond {
namespace {

std::uint8_t srgb_byte(float linear) {
  if (!(linear > 0)) return 0;  // also NaN
  if (linear >= 1) return 255;
  const float encoded = linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(encoded * 255 + 0.5f);
}

// srgb_byte by table. It never falls, so it is told by the least value of each byte; where between two of them a value
// lies, its exponent and the first bits of its mantissa all but say.
class SrgbBytes {
 public:
  SrgbBytes() {
    for (std::uint32_t byte = 1; byte < least_.size(); ++byte) least_[byte] = least_of(static_cast<std::uint8_t>(byte));
    for (std::uint32_t i = 0; i < first_.size(); ++i) {
      first_[i] = srgb_byte(std::bit_cast<float>((i << kShift) + kBegin));
    }
  }

  std::uint8_t operator()(float linear) const {
    if (!(linear > std::bit_cast<float>(kBegin))) return 0;   // also NaN
    if (linear >= 1) return 255;
    std::uint8_t byte = first_[(std::bit_cast<std::uint32_t>(linear) - kBegin) >> kShift];
    while (byte < 255 && linear >= least_[byte + 1u]) ++byte;
    return byte;
  }

 private:
  static constexpr std::uint32_t kBegin = 0x39000000;   // 2⁻¹³, which is black
  static constexpr std::uint32_t kOne = 0x3f800000;
  static constexpr int kShift = 15;                     // 256 places an octave

  static float least_of(std::uint8_t byte) {
    std::uint32_t below = kBegin, at = kOne;
    while (at - below > 1) {
      const std::uint32_t middle = below + (at - below) / 2;
      (srgb_byte(std::bit_cast<float>(middle)) >= byte ? at : below) = middle;
    }
    return std::bit_cast<float>(at);
  }

  std::array<float, 256> least_{};
  std::array<std::uint8_t, ((kOne - kBegin) >> kShift)> first_{};
};

std::vector<std::uint8_t> tone_map(const Image& image, const ToneMap& tone) {
  const float scale = std::exp2(tone.exposure);
  static const SrgbBytes to_byte;
  std::vector<std::uint8_t> bytes(image.pixels.size() * 3);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) bytes[3 * i + static_cast<std::size_t>(c)] = to_byte(image.pixels[i][c] * scale);
  }
  return bytes;
}

/// The pixels with values that a half cannot hold at its largest, instead of infinity.
std::vector<Rgb> half_range(const Image& image) {
  constexpr float kLargestHalf = 65504;
  std::vector<Rgb> pixels = image.pixels;
  for (Rgb& pixel : pixels) pixel = glm::clamp(pixel, Rgb(-kLargestHalf), Rgb(kLargestHalf));
  return pixels;
}

OIIO::ImageSpec make_spec(const Image& image, ImageFormat format) {
  const bool exr = format != ImageFormat::png && format != ImageFormat::jpeg;
  const OIIO::TypeDesc type = !exr                               ? OIIO::TypeUInt8
                              : format == ImageFormat::exr_float ? OIIO::TypeFloat
                                                                 : OIIO::TypeHalf;
  OIIO::ImageSpec spec(image.width, image.height, 3, type);
  spec.channelnames = {"R", "G", "B"};
  spec.attribute("oiio:ColorSpace", exr ? "Linear" : "sRGB");
  // Or the library writes the time of day into EXR files: the same picture is to be the same file.
  if (exr) spec.attribute("DateTime", "");
  if (!image.note.empty()) spec.attribute("ImageDescription", image.note);
  switch (format) {
    case ImageFormat::png:
      spec.attribute("png:compressionLevel", 1);
      break;
    case ImageFormat::jpeg:
      spec.attribute("Compression", "jpeg:90");
      break;
    case ImageFormat::exr_half:
      spec.attribute("compression", "piz");
      break;
    case ImageFormat::exr_half_raw:
      spec.attribute("compression", "none");
      break;
    case ImageFormat::exr_float:
      spec.attribute("compression", "zip");
      break;
  }
  return spec;
}

const char* file_name(ImageFormat format) {
  switch (format) {
    case ImageFormat::png:
      return "memory.png";
    case ImageFormat::jpeg:
      return "memory.jpg";
    default:
      return "memory.exr";
  }
}

Error encoding_failed(const std::string& reason) {
  return {ErrorCode::internal, "the picture cannot be encoded: " + reason, {}};
}

/// The library asks after some rows: true ends the writing.
bool stop_asked(void* stop, float) { return static_cast<const std::stop_token*>(stop)->stop_requested(); }

/// Writes values of the type `from`, as many per pixel as the spec has channels, to memory.
Result<std::vector<std::byte>> write_values(ImageFormat format, const OIIO::ImageSpec& spec, OIIO::TypeDesc from,
                                            const void* values, std::stop_token stop) {
  if (stop.stop_requested()) return cancelled();
  try {
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput proxy(bytes);
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(file_name(format), &proxy);
    if (!output) return encoding_failed(OIIO::geterror());
    constexpr OIIO::stride_t kPacked = OIIO::AutoStride;
    // libpng complains of a PNG that ends early, which is soon done anyway.
    const auto ask = format == ImageFormat::png ? nullptr : stop_asked;
    const bool written = output->open(file_name(format), spec) &&
                         output->write_image(from, values, kPacked, kPacked, kPacked, ask, &stop);
    if (stop.stop_requested()) return cancelled();
    if (!written || !output->close()) return encoding_failed(output->geterror());
    const auto* first = reinterpret_cast<const std::byte*>(bytes.data());
    return std::vector<std::byte>(first, first + bytes.size());
  } catch (const std::exception& exception) {
    return encoding_failed(exception.what());
  }
}

/// Positions of the channels named R, G and B, of a layer where one is named.
Result<std::array<int, 3>> find_rgb(const OIIO::ImageSpec& spec, const std::string& layer) {
  std::array<int, 3> channels{};
  constexpr const char* kNames[] = {"R", "G", "B"};
  for (int c = 0; c < 3; ++c) {
    const std::string name = layer.empty() ? kNames[c] : layer + "." + kNames[c];
    channels[static_cast<std::size_t>(c)] = spec.channelindex(name);
    if (channels[static_cast<std::size_t>(c)] < 0) {
      const ErrorCode code = layer.empty() ? ErrorCode::invalid_input : ErrorCode::not_found;
      return Error{code, "the picture has no channel " + name, ""};
    }
  }
  return channels;
}

Result<Image> read_linear(OIIO::ImageInput& input, const std::string& layer) {
  constexpr int kMaxSide = 16'384;  // of the largest film
  constexpr int kMaxChannels = 64;
  const OIIO::ImageSpec spec = input.spec();
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.deep || spec.width > kMaxSide ||
      spec.height > kMaxSide || spec.nchannels > kMaxChannels) {
    return invalid_input("the picture has " + std::to_string(spec.width) + "x" + std::to_string(spec.height) +
                         " pixels of " + std::to_string(spec.nchannels) + " channels; at most " +
                         std::to_string(kMaxSide) + " a side and " + std::to_string(kMaxChannels) +
                         " flat channels are read");
  }
  if (spec.width != spec.full_width || spec.height != spec.full_height) {
    return invalid_input("the picture is a part of one of " + std::to_string(spec.full_width) + "x" +
                         std::to_string(spec.full_height) + " pixels");
  }
  const Result<std::array<int, 3>> rgb = find_rgb(spec, layer);
  if (!rgb) return rgb.error();
  const auto [first, last] = std::minmax_element(rgb->begin(), rgb->end());
  const auto channels = static_cast<std::size_t>(*last - *first + 1);
  Image image(spec.width, spec.height);
  image.note = spec.get_string_attribute("ImageDescription");
  std::vector<float> values(image.pixels.size() * channels);
  if (!input.read_image(0, 0, *first, *last + 1, OIIO::TypeFloat, values.data())) {
    return invalid_input("the picture cannot be decoded: " + input.geterror());
  }
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      image.pixels[i][static_cast<int>(c)] = values[i * channels + static_cast<std::size_t>((*rgb)[c] - *first)];
    }
  }
  return image;
}

}  // namespace

Result<std::vector<std::byte>> encode(const Image& image, ImageFormat format, const ToneMap& tone,
                                      const std::stop_token& stop) {
  if (image.pixels.empty()) return invalid_input("the picture is empty");
  const OIIO::ImageSpec spec = make_spec(image, format);
  switch (format) {
    case ImageFormat::exr_float:
      return write_values(format, spec, OIIO::TypeFloat, image.pixels.data(), stop);
    case ImageFormat::exr_half:
    case ImageFormat::exr_half_raw:
      return write_values(format, spec, OIIO::TypeFloat, half_range(image).data(), stop);
    default:
      return write_values(format, spec, OIIO::TypeUInt8, tone_map(image, tone).data(), stop);
  }
}

Result<std::vector<std::byte>> encode_exr(const Image& image, const ErrorLayers& error,
                                          const std::stop_token& stop) {
  const std::array<const Image*, 4> layers = {&image, &error.noise, &error.bias, &error.bound};
  for (const Image* layer : layers) {
    if (layer->pixels.empty() || layer->pixels.size() != image.pixels.size()) {
      return invalid_input("the picture and its error have different sizes");
    }
  }
  OIIO::ImageSpec spec = make_spec(image, ImageFormat::exr_float);
  for (const char* layer : {"error.noise", "error.bias", "error.bound"}) {
    for (const char* channel : {".R", ".G", ".B"}) spec.channelnames.push_back(std::string(layer) + channel);
  }
  spec.nchannels = static_cast<int>(spec.channelnames.size());
  std::vector<Rgb> values;
  values.reserve(image.pixels.size() * layers.size());
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    for (const Image* layer : layers) values.push_back(layer->pixels[i]);
  }
  return write_values(ImageFormat::exr_float, spec, OIIO::TypeFloat, values.data(), stop);
}

Result<Image> decode_exr(std::span<const std::byte> bytes, const std::string& layer) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!text.starts_with("\x76\x2f\x31\x01")) return invalid_input("the picture is not OpenEXR");
  try {
    OIIO::Filesystem::IOMemReader reader(const_cast<std::byte*>(bytes.data()), bytes.size());
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open("memory.exr", nullptr, &reader);
    if (!input) return invalid_input("the picture cannot be decoded: " + OIIO::geterror());
    return read_linear(*input, layer);
  } catch (const std::exception& exception) {
    return invalid_input(std::string("the picture cannot be decoded: ") + exception.what());
  }
}

}  // namespace photond
