#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/result.h"
#include "core/film/image.h"

namespace photond {

/// Decodes an OpenEXR file (channels R, G and B, or Y alone) or a Radiance HDR file by OpenImageIO. The limits are
/// compared with the header before anything is decoded. Values are as in the file: they may be negative or no numbers.
/// Errors: unsupported (another format, or pixels that do not begin at the upper left), limit_exceeded, invalid_input
/// (corrupt).
Result<Image> decode_radiance(std::span<const std::byte> bytes, int max_side, std::uint64_t max_pixels);

}  // namespace photond
