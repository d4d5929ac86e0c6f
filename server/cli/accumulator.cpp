#include "server/cli/accumulator.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "core/base/digest.h"
#include "core/film/film_bytes.h"
#include "server/cli/files.h"
#include "server/cli/report_json.h"

namespace photond {
namespace {

constexpr std::uint32_t kVersion = 1;
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

/// Whether the film has the size that the identity states.
bool has_stated_size(const Film& film, const Json& identity) {
  const Json::json_pointer width("/settings/width"), height("/settings/height");
  return identity.contains(width) && identity.contains(height) && identity[width] == film.width &&
         identity[height] == film.height;
}

}  // namespace

Result<Json> task_identity(const RenderTask& task) {
  constexpr std::uint64_t kMaxProgram = 1ull << 30;
  const auto program = read_file("/proc/self/exe", kMaxProgram);
  if (!program) return program.error();
  return Json{{"build", {{"photond", PHOTOND_VERSION}, {"program", to_hex(sha256(*program))}}},
              {"scene", to_hex(task.scene->digest)},
              {"camera", camera_json(task.camera)},
              {"settings", settings_json(task)},
              {"plan", decisions_json(task.plan)}};
}

std::string first_difference(const Json& a, const Json& b) {
  if (!a.is_object() || !b.is_object()) return {};
  const auto differs = [](const Json& x, const Json& y, const std::string& key) {
    return x.contains(key) != y.contains(key) || (x.contains(key) && x[key] != y[key]);
  };
  for (const Json* side : {&a, &b}) {
    for (const auto& item : side->items()) {
      const std::string& key = item.key();
      if (!differs(a, b, key)) continue;
      if (!a.contains(key) || !b.contains(key)) return key;
      const std::string inner = first_difference(a[key], b[key]);
      return inner.empty() ? key : key + "." + inner;
    }
  }
  return {};
}

std::vector<std::byte> accumulator_bytes(const Accumulator& accumulator) {
  const std::string identity = to_text(accumulator.identity);
  const std::vector<std::byte> film = film_bytes(accumulator.film);
  Header header;
  header.identity_bytes = static_cast<std::uint32_t>(identity.size());
  header.file_bytes = sizeof header + identity.size() + film.size() + kDigestBytes;
  std::vector<std::byte> bytes(header.file_bytes);
  std::size_t end = 0;
  const auto append = [&](std::span<const std::byte> part) {
    std::copy(part.begin(), part.end(), bytes.begin() + static_cast<std::ptrdiff_t>(end));
    end += part.size();
  };
  append(std::as_bytes(std::span(&header, 1)));
  append(std::as_bytes(std::span(identity)));
  append(film);
  const Digest digest = sha256(std::span(bytes).first(end));
  append(std::as_bytes(std::span(digest.bytes)));
  return bytes;
}

Result<Accumulator> read_accumulator(std::span<const std::byte> bytes) {
  const auto header = check_file(bytes);
  if (!header) return header.error();
  const auto content = bytes.subspan(sizeof(Header), bytes.size() - sizeof(Header) - kDigestBytes);
  auto identity = parse_json(content.first(header->identity_bytes));
  if (!identity) return invalid_input("is damaged: its identity is " + identity.error().message);
  auto film = read_film(content.subspan(header->identity_bytes));
  if (!film) return invalid_input("is damaged: " + film.error().message);
  if (!has_stated_size(*film, *identity)) return invalid_input("is damaged: its film has not the size it states");
  return Accumulator{std::move(*identity), std::move(*film)};
}

}  // namespace photond
