#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "core/base/digest.h"
#include "core/base/parallel.h"

namespace photond {

/// Bytes that never change, and what keeps them alive: a mapped file, a vector.
struct SharedSpan {
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> owner;
};

/// The format of files that are used where they lie: a head, then up to kMaxSections arrays, each from a multiple of
/// kAlignment bytes on, with nothing but zeros between them. The head tells an `identity` (what the file holds, by which
/// program), the size of the file, and of each section its place, size and checksum; a checksum of its own ends it.
/// Little-endian. Every bit of such a file is checked, so a changed, missing or added one is noticed.
class Sections {
 public:
  static constexpr std::size_t kMaxSections = 13;
  static constexpr std::size_t kAlignment = 64;
  static constexpr std::size_t kHeadBytes = 384;

  /// Checks everything but what the sections contain. Nothing where the bytes are not a whole, undamaged file of this
  /// identity, or are not aligned.
  static std::optional<Sections> read(SharedSpan file, const Digest& identity, const Execution& execution);

  /// The identity told by a head, of which neither checksum nor file is checked; nothing where it is none.
  static std::optional<Digest> told_identity(std::span<const std::byte> head);

  std::size_t count() const { return sections_.size(); }
  /// Section i as values; nothing where there is no such section or its size is no multiple of theirs.
  template <class T>
  std::optional<std::span<const T>> get(std::size_t i) const {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= kAlignment);
    if (i >= sections_.size() || sections_[i].size() % sizeof(T) != 0) return std::nullopt;
    return std::span<const T>(reinterpret_cast<const T*>(sections_[i].data()), sections_[i].size() / sizeof(T));
  }
  const std::shared_ptr<const void>& owner() const { return owner_; }

 private:
  std::vector<std::span<const std::byte>> sections_;
  std::shared_ptr<const void> owner_;
};

/// What becomes such a file. Refers to the added arrays, which must live as long.
class SectionList {
 public:
  SectionList() = default;
  SectionList(SectionList&&) = default;
  SectionList(const SectionList&) = delete;

  template <class T>
  void add(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    sections_.push_back(std::as_bytes(values));
  }
  /// Adds a section of one value, of which a copy is kept.
  template <class T>
  void add_value(const T& value) {
    const auto bytes = std::as_bytes(std::span<const T>(&value, 1));
    values_.emplace_back(bytes.begin(), bytes.end());
    sections_.push_back(values_.back());
  }

  /// The file in pieces, which live as long as the list. At most kMaxSections may have been added.
  std::vector<std::span<const std::byte>> pieces(const Digest& identity, const Execution& execution);

 private:
  std::vector<std::span<const std::byte>> sections_;
  std::deque<std::vector<std::byte>> values_;
  std::vector<std::byte> head_;
};

/// Tells damage, not intent: any change within one aligned word of eight bytes changes the sum for certain, anything else but once in about 2⁶⁴.
std::uint64_t checksum(std::span<const std::byte> bytes, const Execution& execution);

}  // namespace photond
