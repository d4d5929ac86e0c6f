#include "server/store/accumulator.h"

#include <array>
#include <cassert>
#include <cstring>

#include "core/base/digest.h"

namespace photond {
namespace {

constexpr std::uint32_t kVersion = 2;
constexpr std::uint32_t kMaxIdentity = 1u << 20;  // bytes; an identity has about two thousand

struct Header {
  std::array<char, 8> magic = {'p', 'h', 'o', 't', 'a', 'c', 'c', 0};
  std::uint32_t version = kVersion;
  std::uint32_t identity_bytes = 0;
  std::uint64_t file_bytes = 0;
};
static_assert(sizeof(Header) == 24, "no padding");

constexpr std::size_t kDigestBytes = sizeof(Digest::bytes);

/// The header of bytes whose length and checksum are right.
Result<Header> check_file(std::span<const std::byte> bytes) {
  Header header;
  if (bytes.size() < sizeof header.magic || std::memcmp(bytes.data(), header.magic.data(), sizeof header.magic) != 0) {
    return invalid_input("is not an accumulator file");
  }
  if (bytes.size() < sizeof header) return invalid_input("is truncated");
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.version != kVersion) {
    return invalid_input("is an accumulator of version " + std::to_string(header.version) + ", not " +
                         std::to_string(kVersion));
  }
  if (bytes.size() < header.file_bytes) {
    return invalid_input("is truncated: it has " + std::to_string(bytes.size()) + " of " +
                         std::to_string(header.file_bytes) + " bytes");
  }
  const Error damaged = invalid_input("is damaged: its checksum is wrong");
  if (bytes.size() > header.file_bytes || bytes.size() < sizeof header + kDigestBytes) return damaged;
  const auto content = bytes.first(bytes.size() - kDigestBytes);
  const Digest digest = sha256(content);
  if (std::memcmp(digest.bytes.data(), bytes.last(kDigestBytes).data(), kDigestBytes) != 0) return damaged;
  if (header.identity_bytes > kMaxIdentity || header.identity_bytes > content.size() - sizeof header) {
    return invalid_input("is damaged: its identity is longer than allowed");
  }
  return header;
}

}  // namespace

Status write_accumulator(const std::string& identity, const Film& film, const ByteSink& sink) {
  Header header;
  header.identity_bytes = static_cast<std::uint32_t>(identity.size());
  header.file_bytes = sizeof header + identity.size() + film_size(film) + kDigestBytes;
  Hasher hasher;
  const ByteSink hashed = [&](std::span<const std::byte> piece) {
    hasher.update(piece);
    return sink(piece);
  };
  Status written = hashed(std::as_bytes(std::span(&header, 1)));
  if (written) written = hashed(std::as_bytes(std::span(identity)));
  if (written) written = write_film(film, hashed);
  if (!written) return written;
  const Digest digest = hasher.finish();
  return sink(std::as_bytes(std::span(digest.bytes)));
}

std::vector<std::byte> accumulator_bytes(const Accumulator& accumulator) {
  std::vector<std::byte> bytes;
  const ByteSink append = [&bytes](std::span<const std::byte> piece) -> Status {
    bytes.insert(bytes.end(), piece.begin(), piece.end());
    return Done{};
  };
  [[maybe_unused]] const Status written = write_accumulator(accumulator.identity, accumulator.film, append);
  assert(written.ok());
  return bytes;
}

Result<Accumulator> read_accumulator(std::span<const std::byte> bytes) {
  const auto header = check_file(bytes);
  if (!header) return header.error();
  const auto content = bytes.subspan(sizeof(Header), bytes.size() - sizeof(Header) - kDigestBytes);
  const auto text = content.first(header->identity_bytes);
  auto film = read_film(content.subspan(header->identity_bytes));
  if (!film) return invalid_input("is damaged: " + film.error().message);
  return Accumulator{{reinterpret_cast<const char*>(text.data()), text.size()}, std::move(*film)};
}

}  // namespace photond
