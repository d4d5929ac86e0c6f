#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/film/error.h"
#include "core/film/image.h"

namespace photond {

enum class ImageFormat { png, jpeg, exr_half, exr_half_raw, exr_float };

/// How radiance becomes 8-bit sRGB: multiplied by 2^exposure, clipped at 1, sRGB-encoded.
struct ToneMap {
  float exposure = 0;
};

/// Encodes to memory by OpenImageIO. PNG (level 1) and JPEG (quality 90) are tone-mapped to 8-bit sRGB; EXR is
/// linear R, G, B (half: PIZ, or raw and ten times as fast; float: ZIP), first scanline on top.
/// Errors: cancelled, as soon as `stop` asks; internal.
Result<std::vector<std::byte>> encode(const Image& image, ImageFormat format, const ToneMap& tone = {},
                                      const std::stop_token& stop = {});

/// A float EXR of the picture with its error as further channels: error.noise.R … error.bound.B. Errors: as encode.
Result<std::vector<std::byte>> encode_exr(const Image& image, const ErrorLayers& error,
                                          const std::stop_token& stop = {});

/// Decodes the channels R, G and B of an EXR (or any file OpenImageIO reads as linear float); others are left out. With
/// `layer` ("error.noise") those of this layer of encode_exr. Errors: invalid_input, not_found (no such layer).
Result<Image> decode_exr(std::span<const std::byte> bytes, const std::string& layer = {});

}  // namespace photond
