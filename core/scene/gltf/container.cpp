#include "core/scene/gltf/container.h"

#include <cstdint>
#include <string>

namespace photond::gltf {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67;  // "glTF"
constexpr std::uint32_t kJson = 0x4E4F534A;   // "JSON"
constexpr std::uint32_t kBin = 0x004E4942;    // "BIN\0"
constexpr std::size_t kHeaderSize = 12;
constexpr std::size_t kChunkHeaderSize = 8;
constexpr std::size_t kMaxSize = 0xFFFFFFFFu;  // GLB sizes and the parser's length are 32-bit

std::uint32_t read_u32(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::to_integer<std::uint32_t>(bytes[at + i]) << (8 * i);
  return value;
}

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

struct Chunk {
  std::uint32_t type = 0;
  std::span<const std::byte> data;
};

/// Takes the chunk at the front of `rest`.
Result<Chunk> take_chunk(std::span<const std::byte>& rest, const std::string& where) {
  if (rest.size() < kChunkHeaderSize) return invalid_input("chunk header is truncated", where);
  const std::size_t length = read_u32(rest, 0);
  if (length % 4 != 0) return invalid_input("chunk length is not a multiple of 4", where);
  if (length > rest.size() - kChunkHeaderSize) return invalid_input("chunk is truncated", where);
  const Chunk chunk{read_u32(rest, 4), rest.subspan(kChunkHeaderSize, length)};
  rest = rest.subspan(kChunkHeaderSize + length);
  return chunk;
}

Status check_header(std::span<const std::byte> bytes) {
  if (bytes.size() < kHeaderSize) return invalid_input("GLB header is truncated", "header");
  if (read_u32(bytes, 4) != 2) return invalid_input("GLB version is not 2", "header.version");
  if (read_u32(bytes, 8) != bytes.size()) {
    return invalid_input("length in the GLB header differs from the size of the file", "header.length");
  }
  return Done{};
}

Result<Container> open_glb(std::span<const std::byte> bytes) {
  if (Status header = check_header(bytes); !header) return header.error();
  std::span<const std::byte> rest = bytes.subspan(kHeaderSize);
  Container container{.binary = true};
  for (std::size_t i = 0; !rest.empty() || i == 0; ++i) {
    const std::string where = "chunks[" + std::to_string(i) + "]";
    Result<Chunk> chunk = take_chunk(rest, where);
    if (!chunk) return chunk.error();
    if (i == 0) {
      if (chunk->type != kJson) return invalid_input("the first chunk is not JSON", where);
      container.json = as_text(chunk->data);
    } else if (chunk->type == kBin && i == 1) {
      container.bin = chunk->data;
    } else if (chunk->type == kBin || chunk->type == kJson) {
      return invalid_input("misplaced JSON or BIN chunk", where);
    }
  }
  return container;
}

}  // namespace

Result<Container> open_container(std::span<const std::byte> bytes) {
  if (bytes.empty()) return invalid_input("the file is empty");
  if (bytes.size() > kMaxSize) return Error{ErrorCode::limit_exceeded, "the file is larger than 4 GiB", {}};
  if (bytes.size() >= 4 && read_u32(bytes, 0) == kMagic) return open_glb(bytes);
  std::string_view text = as_text(bytes);
  // glTF has no byte order mark, but editors on Windows write one, and a reader may ignore it [RFC 8259, 8.1].
  if (constexpr std::string_view kMark = "\xEF\xBB\xBF"; text.starts_with(kMark)) text.remove_prefix(kMark.size());
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos || text[first] != '{')
    return invalid_input("the file is neither GLB nor the JSON of a glTF");
  return Container{.json = text};
}

}  // namespace photond::gltf
