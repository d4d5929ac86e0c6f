#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/result.h"

namespace photond {

/// Pixels as a file stores them (no colour conversion, alpha not multiplied in), widened to RGBA, first row on
/// top. Exactly one of `u8` and `u16` is filled.
struct DecodedPixels {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> u8;
  std::vector<std::uint16_t> u16;
};

struct DecodeLimits {
  int max_side = 16'384;
  std::uint64_t max_pixels = 256'000'000;
};

/// Decodes a PNG, JPEG or WebP file by OpenImageIO. The limits are compared with the header before anything is
/// decoded. Errors: unsupported (another format), limit_exceeded, invalid_input (corrupt).
Result<DecodedPixels> decode_pixels(std::span<const std::byte> bytes, const DecodeLimits& limits = {});

}  // namespace photond
