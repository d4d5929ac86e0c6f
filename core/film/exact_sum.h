#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace photond {

/// Values at or beyond this magnitude (7·10¹⁰) do not fit the sums below; the sun's disc has a radiance of
/// 2·10⁷ W·m⁻²·sr⁻¹ and a luminance of 1.6·10⁹ cd·m⁻².
inline constexpr float kLargestSummand = 0x1p36f;

/// static_cast<double>, several at a time where numbers lie in a row: halves become mantissas of 2⁸⁴ and 2⁵².
inline double to_double(std::uint64_t x) {
  const auto high = std::bit_cast<double>(x >> 32 | std::bit_cast<std::uint64_t>(0x1p84));
  const auto low = std::bit_cast<double>((x & 0xffffffffu) | std::bit_cast<std::uint64_t>(0x1p52));
  return (high - 0x1p84) + (low - 0x1p52);
}

/// A sum of floats in fixed point: integer addition is associative, so that a sum does not depend on how it was
/// split. Unit 2⁻⁶⁴ (floats from 2⁻⁴⁰ ≈ 10⁻¹² on are exact, smaller ones are cut), room for 2²⁶ of the largest
/// summands.
struct ExactSum {
  unsigned __int128 bits = 0;  ///< two's complement

  /// |x| < kLargestSummand. Without branches: which values are black or small, none could predict.
  void add(float x) {
    const auto raw = std::bit_cast<std::uint32_t>(x);
    const int exponent = static_cast<int>((raw >> 23) & 0xff);
    const unsigned __int128 mantissa = (raw & 0x7fffffu) | 0x800000u;
    // x = ±mantissa·2^(exponent − 150) = ±mantissa·2^(exponent − 62)·2⁻²⁴ units; what is below one is cut.
    const unsigned __int128 magnitude = mantissa << std::max(exponent - 62, 0) >> 24;
    const unsigned __int128 sign = -static_cast<unsigned __int128>(raw >> 31);   // all bits or none
    bits += (magnitude ^ sign) - sign;
  }
  void add(const ExactSum& other) { bits += other.bits; }

  double value() const {
    const bool negative = (bits >> 127) != 0;
    const unsigned __int128 magnitude = negative ? -bits : bits;
    const double value = to_double(static_cast<std::uint64_t>(magnitude >> 64)) +
                         to_double(static_cast<std::uint64_t>(magnitude)) * 0x1p-64;
    return negative ? -value : value;
  }
  bool operator==(const ExactSum&) const = default;
};

/// Adds each of `count` floats to the sum in its place.
void add(ExactSum* sums, const float* x, std::size_t count);

/// The values of `count` sums.
void values(const ExactSum* sums, double* x, std::size_t count);

/// The same for squares: unit 2⁻⁹⁶, room for 2²⁴ squares of the largest summand.
struct ExactSquareSum {
  std::array<std::uint64_t, 3> words{};  ///< least significant first

  /// Adds x², |x| < kLargestSummand, cut to 53 bits.
  void add_square(double x) {
    const auto raw = std::bit_cast<std::uint64_t>(x * x);
    const int exponent = static_cast<int>(raw >> 52);
    const std::uint64_t mantissa = (raw & 0xfffffffffffffu) | 0x10000000000000u;
    const int shift = exponent - 1075 + 96;  // x² = mantissa·2^(exponent − 1075)
    if (shift >= 64) {
      const unsigned __int128 wide = static_cast<unsigned __int128>(mantissa) << (shift - 64);
      add(0, static_cast<std::uint64_t>(wide), static_cast<std::uint64_t>(wide >> 64));
    } else {
      // As above without branches: one of the two shifts is by nothing, or leaves nothing.
      const unsigned __int128 wide = static_cast<unsigned __int128>(mantissa >> std::clamp(-shift, 0, 63))
                                     << std::max(shift, 0);
      add(static_cast<std::uint64_t>(wide), static_cast<std::uint64_t>(wide >> 64), 0);
    }
  }
  void add(const ExactSquareSum& other) { add(other.words[0], other.words[1], other.words[2]); }

  double value() const {
    return to_double(words[2]) * 0x1p32 + to_double(words[1]) * 0x1p-32 + to_double(words[0]) * 0x1p-96;
  }
  bool operator==(const ExactSquareSum&) const = default;

 private:
  void add(std::uint64_t low, std::uint64_t middle, std::uint64_t high) {
    using Wide = unsigned __int128;
    const Wide first = static_cast<Wide>(words[0]) + low;
    const Wide second = static_cast<Wide>(words[1]) + middle + static_cast<std::uint64_t>(first >> 64);
    words[0] = static_cast<std::uint64_t>(first);
    words[1] = static_cast<std::uint64_t>(second);
    words[2] += high + static_cast<std::uint64_t>(second >> 64);
  }
};

/// Adds the square of each of `count` floats to the sum in its place.
void add_squares(ExactSquareSum* sums, const float* x, std::size_t count);

/// The values of `count` sums.
void values(const ExactSquareSum* sums, double* x, std::size_t count);

}  // namespace photond
