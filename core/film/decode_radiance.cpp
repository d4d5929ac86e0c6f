#include "core/film/decode_radiance.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <vector>

namespace photond {
namespace {

/// The format by its signature, as a file name for OpenImageIO; empty where it is neither.
std::string format_name(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.starts_with("\x76\x2f\x31\x01")) return "memory.exr";
  if (text.starts_with("#?")) return "memory.hdr";
  return {};
}

Status check_header(const OIIO::ImageSpec& spec, int max_side, std::uint64_t max_pixels) {
  constexpr int kMaxChannels = 64;
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.deep || spec.nchannels > kMaxChannels) {
    return invalid_input("the picture has a size, depth or channel count that is not allowed");
  }
  const std::string size = std::to_string(spec.width) + "x" + std::to_string(spec.height);
  const auto pixels = static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.height);
  if (spec.width > max_side || spec.height > max_side || pixels > max_pixels) {
    return Error{ErrorCode::limit_exceeded,
                 "the picture of " + size + " pixels is larger than allowed: " + std::to_string(max_side) +
                     " a side, " + std::to_string(max_pixels) + " in all",
                 {}};
  }
  if (spec.width != spec.full_width || spec.height != spec.full_height) {
    return invalid_input("the picture of " + size + " pixels is a part of one of " + std::to_string(spec.full_width) +
                         "x" + std::to_string(spec.full_height));
  }
  if (spec.get_int_attribute("Orientation", 1) != 1) {
    return Error{ErrorCode::unsupported, "the picture is stored turned or mirrored", {}};
  }
  return Done{};
}

/// Positions of the channels that are red, green and blue.
Result<std::array<int, 3>> find_channels(const OIIO::ImageSpec& spec) {
  const std::array<int, 3> rgb = {spec.channelindex("R"), spec.channelindex("G"), spec.channelindex("B")};
  if (rgb[0] >= 0 && rgb[1] >= 0 && rgb[2] >= 0) return rgb;
  const int grey = spec.channelindex("Y");
  if (grey >= 0) return std::array<int, 3>{grey, grey, grey};
  return invalid_input("the picture has neither the channels R, G and B nor Y");
}

Result<Image> read_opened(OIIO::ImageInput& input, int max_side, std::uint64_t max_pixels) {
  const OIIO::ImageSpec spec = input.spec();
  if (Status status = check_header(spec, max_side, max_pixels); !status) return status.error();
  const Result<std::array<int, 3>> channels = find_channels(spec);
  if (!channels) return channels.error();
  const auto [first, last] = std::minmax_element(channels->begin(), channels->end());
  const auto stride = static_cast<std::size_t>(*last - *first + 1);
  Image image(spec.width, spec.height);
  std::vector<float> values(image.pixels.size() * stride);
  if (!input.read_image(0, 0, *first, *last + 1, OIIO::TypeFloat, values.data())) {
    return invalid_input("the picture is corrupt: " + input.geterror().substr(0, 200));
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const auto from = static_cast<std::size_t>((*channels)[c] - *first);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i][static_cast<int>(c)] = values[i * stride + from];
  }
  return image;
}

}  // namespace

Result<Image> decode_radiance(std::span<const std::byte> bytes, int max_side, std::uint64_t max_pixels) {
  const std::string name = format_name(bytes);
  if (name.empty()) return Error{ErrorCode::unsupported, "the picture is neither OpenEXR nor Radiance HDR", {}};
  try {
    OIIO::Filesystem::IOMemReader reader(const_cast<std::byte*>(bytes.data()), bytes.size());
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(name, nullptr, &reader);
    if (!input) return invalid_input("the picture is corrupt: " + OIIO::geterror().substr(0, 200));
    return read_opened(*input, max_side, max_pixels);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::limit_exceeded, "the picture needs more memory than there is", {}};
  } catch (const std::exception& exception) {
    return invalid_input(std::string("the picture is corrupt: ") + exception.what());
  }
}

}  // namespace photond
