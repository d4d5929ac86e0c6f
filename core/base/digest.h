#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace photond {

/// A SHA-256 value: the name of a content.
struct Digest {
  std::array<std::uint8_t, 32> bytes{};
  auto operator<=>(const Digest&) const = default;
};

/// 64 lower-case hexadecimal characters.
std::string to_hex(const Digest& digest);

/// The digest written as 64 hexadecimal characters, or nothing where `text` is not that.
std::optional<Digest> digest_from_hex(std::string_view text);

/// Incremental SHA-256 (OpenSSL).
class Hasher {
 public:
  Hasher();
  ~Hasher();
  Hasher(Hasher&&) noexcept;
  Hasher& operator=(Hasher&&) noexcept;

  void update(std::span<const std::byte> bytes);
  void update(std::string_view text);
  /// The bytes of one trivially copyable value without padding.
  template <class T>
  void update_value(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    update(std::as_bytes(std::span<const T>(&value, 1)));
  }
  /// Ends the computation; the hasher may not be used afterwards.
  Digest finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

Digest sha256(std::span<const std::byte> bytes);

}  // namespace photond
