#include "core/film/decode.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <string_view>

#include "core/film/png_chunks.h"

namespace photond {
namespace {

/// The format by its signature, as a file name for OpenImageIO; empty where it is none of the three. Only these
/// decoders are ever given foreign bytes.
std::string format_name(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  using namespace std::string_view_literals;
  if (text.starts_with("\x89PNG\r\n\x1a\n"sv)) return "memory.png";
  if (text.starts_with("\xFF\xD8\xFF"sv)) return "memory.jpg";
  if (text.starts_with("RIFF"sv) && text.substr(std::min<std::size_t>(8, text.size()), 4) == "WEBP"sv) {
    return "memory.webp";
  }
  return {};
}

Status check_size(const OIIO::ImageSpec& spec, const DecodeLimits& limits) {
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.nchannels < 1 || spec.nchannels > 4) {
    return invalid_input("image has a size or channel count that is not allowed");
  }
  const auto pixels = static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.height);
  if (spec.width > limits.max_side || spec.height > limits.max_side || pixels > limits.max_pixels) {
    return Error{ErrorCode::limit_exceeded,
                 "image of " + std::to_string(spec.width) + "x" + std::to_string(spec.height) +
                     " pixels is larger than allowed",
                 {}};
  }
  return Done{};
}

/// Each scan of a JPEG goes through all its pixels, and some hundred bytes are enough for one. Real files have ten or
/// so. Counts the marker wherever it is: among the scans' own bytes it is nothing else, in metadata it is rare.
Status check_scans(std::span<const std::byte> jpeg) {
  constexpr int kMostScans = 128;
  int scans = 0;
  for (std::size_t i = 0; i + 1 < jpeg.size(); ++i) {
    if (jpeg[i] == std::byte{0xFF} && jpeg[i + 1] == std::byte{0xDA}) ++scans;
  }
  if (scans <= kMostScans) return Done{};
  return Error{ErrorCode::limit_exceeded, "image is a JPEG of more than " + std::to_string(kMostScans) + " scans", {}};
}

/// Spreads `channels` values per pixel to RGBA in place: grey is repeated, missing alpha is opaque.
template <class T>
void widen_to_rgba(std::vector<T>& values, std::size_t pixels, int channels) {
  constexpr T kOpaque = static_cast<T>(~T{0});
  for (std::size_t i = pixels; channels < 4 && i-- > 0;) {
    const T* from = &values[i * static_cast<std::size_t>(channels)];
    const bool grey = channels < 3;
    const T r = from[0], g = grey ? from[0] : from[1], b = grey ? from[0] : from[2];
    const T a = channels == 2 ? from[1] : kOpaque;
    T* to = &values[i * 4];
    to[0] = r, to[1] = g, to[2] = b, to[3] = a;
  }
}

template <class T>
Status read_rgba(OIIO::ImageInput& input, OIIO::TypeDesc type, std::vector<T>& out) {
  const OIIO::ImageSpec spec = input.spec();
  const std::size_t pixels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  out.resize(pixels * 4);
  if (!input.read_image(0, 0, 0, spec.nchannels, type, out.data())) {
    std::string reason = input.geterror();
    return invalid_input("image is corrupt" + (reason.empty() ? "" : ": " + reason.substr(0, 200)));
  }
  widen_to_rgba(out, pixels, spec.nchannels);
  return Done{};
}

Result<DecodedPixels> decode_opened(OIIO::ImageInput& input, const DecodeLimits& limits) {
  const OIIO::ImageSpec& spec = input.spec();
  if (Status status = check_size(spec, limits); !status) return status.error();
  DecodedPixels pixels{.width = spec.width, .height = spec.height};
  const bool deep = spec.format.basesize() > 1;
  const Status status =
      deep ? read_rgba(input, OIIO::TypeUInt16, pixels.u16) : read_rgba(input, OIIO::TypeUInt8, pixels.u8);
  if (!status) return status.error();
  return pixels;
}

Result<DecodedPixels> decode_named(const std::string& name, std::span<const std::byte> bytes,
                                   const DecodeLimits& limits) {
  try {
    OIIO::Filesystem::IOMemReader reader(const_cast<std::byte*>(bytes.data()), bytes.size());
    // The proxy has to be in the configuration too: with one given, 2.4 looks for it only there.
    OIIO::Filesystem::IOProxy* proxy = &reader;
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(name, &config, proxy);
    if (!input) return invalid_input("image is corrupt: " + OIIO::geterror().substr(0, 200));
    return decode_opened(*input, limits);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::limit_exceeded, "image needs more memory than there is", {}};
  } catch (const std::exception& exception) {
    return invalid_input(std::string("image is corrupt: ") + exception.what());
  }
}

}  // namespace

Result<DecodedPixels> decode_pixels(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  const std::string name = format_name(bytes);
  if (name.empty()) return Error{ErrorCode::unsupported, "image is neither PNG, JPEG nor WebP", {}};
  if (name == "memory.jpg") {
    if (Status status = check_scans(bytes); !status) return status.error();
  }
  if (name != "memory.png") return decode_named(name, bytes, limits);
  const Result<std::vector<std::byte>> png = keep_pixel_chunks(bytes);
  return png ? decode_named(name, *png, limits) : Result<DecodedPixels>(png.error());
}

}  // namespace photond
