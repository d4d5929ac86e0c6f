#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/result.h"

namespace photond {

/// A copy of a PNG file with nothing but the chunks that make up its pixels (IHDR, PLTE, tRNS, IDAT, IEND), so
/// that libpng cannot be made to allocate for the claimed size of any other. Errors: a chunk that exceeds the
/// file.
Result<std::vector<std::byte>> keep_pixel_chunks(std::span<const std::byte> png);

}  // namespace photond
