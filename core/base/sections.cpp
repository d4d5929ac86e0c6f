#include "core/base/sections.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>

namespace photond {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

constexpr std::array<char, 8> kMagic = {'p', 'h', 'o', 't', 's', 'e', 'c', '1'};

struct Entry {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;
};

struct Head {
  std::array<char, 8> magic = kMagic;
  std::array<std::uint8_t, 32> identity{};
  std::uint64_t file_bytes = 0;
  std::uint64_t count = 0;
  std::array<Entry, Sections::kMaxSections> entries{};
  std::array<std::uint64_t, 1> reserved{};
  std::uint64_t checksum = 0;   // of all that stands before it
};
static_assert(sizeof(Head) == Sections::kHeadBytes && Sections::kHeadBytes % Sections::kAlignment == 0);

std::uint64_t aligned(std::uint64_t offset) {
  return (offset + Sections::kAlignment - 1) / Sections::kAlignment * Sections::kAlignment;
}

std::uint64_t head_checksum(const Head& head) {
  return checksum(std::as_bytes(std::span(&head, 1)).first(offsetof(Head, checksum)), Execution{});
}

// One to one in each argument.
std::uint64_t mix(std::uint64_t sum, std::uint64_t word) {
  sum = (sum ^ word) * 0x9fb21c651e98df25ULL;
  return sum ^ sum >> 32;
}

std::uint64_t word_at(const std::byte* p, std::size_t bytes = sizeof(std::uint64_t)) {
  std::uint64_t word = 0;
  std::memcpy(&word, p, bytes);
  return word;
}

// Lanes do not wait for each other's multiplications.
std::uint64_t block_checksum(std::span<const std::byte> bytes) {
  constexpr std::size_t kSumLanes = 8;
  constexpr std::size_t kStride = kSumLanes * sizeof(std::uint64_t);
  std::array<std::uint64_t, kSumLanes> lanes{1, 2, 3, 4, 5, 6, 7, 8};
  const std::byte* p = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= kStride; left -= kStride, p += kStride) {
    for (std::size_t i = 0; i < kSumLanes; ++i) lanes[i] = mix(lanes[i], word_at(p + i * sizeof(std::uint64_t)));
  }
  std::uint64_t sum = bytes.size();
  for (const std::uint64_t lane : lanes) sum = mix(sum, lane);
  for (; left > 0;) {
    const std::size_t n = std::min(left, sizeof(std::uint64_t));
    sum = mix(sum, word_at(p, n));
    left -= n;
    p += n;
  }
  return sum;
}

bool all_zero(std::span<const std::byte> bytes) {
  return std::ranges::all_of(bytes, [](std::byte b) { return b == std::byte{0}; });
}

}  // namespace

std::uint64_t checksum(std::span<const std::byte> bytes, const Execution& execution) {
  constexpr std::size_t kBlock = std::size_t{1} << 18;
  std::vector<std::uint64_t> sums((bytes.size() + kBlock - 1) / kBlock);
  // A cancelled sum would look like damage.
  const Execution uninterrupted{execution.arena, {}};
  parallel_for(uninterrupted, sums.size(), 1, [&](std::size_t i) {
    sums[i] = block_checksum(bytes.subspan(i * kBlock, std::min(kBlock, bytes.size() - i * kBlock)));
  });
  return block_checksum(std::as_bytes(std::span(sums)));
}

std::optional<Digest> Sections::told_identity(std::span<const std::byte> bytes) {
  Head head;
  if (bytes.size() < sizeof head) return std::nullopt;
  std::memcpy(&head, bytes.data(), sizeof head);
  if (head.magic != kMagic) return std::nullopt;
  return Digest{head.identity};
}

std::optional<Sections> Sections::read(SharedSpan file, const Digest& identity, const Execution& execution) {
  Head head;
  const auto bytes = file.bytes;
  if (told_identity(bytes) != identity || reinterpret_cast<std::uintptr_t>(bytes.data()) % kAlignment != 0) {
    return std::nullopt;
  }
  std::memcpy(&head, bytes.data(), sizeof head);
  if (head.checksum != head_checksum(head) || head.file_bytes != bytes.size() || head.count > kMaxSections) {
    return std::nullopt;
  }
  Sections sections;
  std::uint64_t end = sizeof head;
  for (std::size_t i = 0; i < head.count; ++i) {
    const Entry& entry = head.entries[i];
    // In order and without overlap; what is between them is looked at, too.
    if (entry.offset != aligned(end) || entry.offset > bytes.size() || entry.bytes > bytes.size() - entry.offset) {
      return std::nullopt;
    }
    const auto section = bytes.subspan(entry.offset, entry.bytes);
    if (!all_zero(bytes.subspan(end, entry.offset - end)) || checksum(section, execution) != entry.checksum) {
      return std::nullopt;
    }
    sections.sections_.push_back(section);
    end = entry.offset + entry.bytes;
  }
  if (end != bytes.size()) return std::nullopt;
  sections.owner_ = std::move(file.owner);
  return sections;
}

std::vector<std::span<const std::byte>> SectionList::pieces(const Digest& identity, const Execution& execution) {
  static constexpr std::array<std::byte, Sections::kAlignment> kZeros{};
  assert(sections_.size() <= Sections::kMaxSections);
  Head head{.identity = identity.bytes, .count = sections_.size()};
  std::uint64_t end = sizeof head;
  std::vector<std::span<const std::byte>> pieces{{}};
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    head.entries[i] = {aligned(end), sections_[i].size(), checksum(sections_[i], execution)};
    pieces.push_back(std::span(kZeros).first(aligned(end) - end));
    pieces.push_back(sections_[i]);
    end = aligned(end) + sections_[i].size();
  }
  head.file_bytes = end;
  head.checksum = head_checksum(head);
  const auto bytes = std::as_bytes(std::span(&head, 1));
  head_.assign(bytes.begin(), bytes.end());
  pieces.front() = head_;
  return pieces;
}

}  // namespace photond
