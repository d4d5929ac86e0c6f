#include "core/film/png_chunks.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace photond {
namespace {

constexpr std::size_t kSignatureSize = 8;
constexpr std::size_t kChunkOverhead = 12;  // length, type, checksum

std::size_t read_length(std::span<const std::byte> chunk) {
  std::size_t length = 0;
  for (std::size_t i = 0; i < 4; ++i) length = length << 8 | std::to_integer<std::size_t>(chunk[i]);
  return length;
}

bool makes_pixels(std::string_view type) {
  constexpr std::array<std::string_view, 5> kTypes = {"IHDR", "PLTE", "tRNS", "IDAT", "IEND"};
  return std::find(kTypes.begin(), kTypes.end(), type) != kTypes.end();
}

}  // namespace

Result<std::vector<std::byte>> keep_pixel_chunks(std::span<const std::byte> png) {
  const auto truncated = [] { return invalid_input("image is corrupt: a PNG chunk exceeds the file"); };
  if (png.size() < kSignatureSize) return truncated();
  std::vector<std::byte> out(png.begin(), png.begin() + kSignatureSize);
  std::span<const std::byte> rest = png.subspan(kSignatureSize);
  while (true) {
    if (rest.size() < kChunkOverhead) return truncated();
    const std::size_t length = read_length(rest);
    if (length > rest.size() - kChunkOverhead) return truncated();
    const std::string_view type(reinterpret_cast<const char*>(rest.data()) + 4, 4);
    const auto chunk = rest.first(length + kChunkOverhead);
    if (makes_pixels(type)) out.insert(out.end(), chunk.begin(), chunk.end());
    if (type == "IEND") return out;
    rest = rest.subspan(chunk.size());
  }
}

}  // namespace photond
