#include "core/film/exact_sum.h"

#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace photond {

namespace {

#ifdef __AVX2__
constexpr std::size_t kTogether = 4;

// x · 2^shift, of 64 bits that begin at the lowest; shifts by 64 and more leave nothing, whether left or right.
__m256i shifted(const __m256i& x, const __m256i& shift) {
  return _mm256_or_si256(_mm256_sllv_epi64(x, shift),
                         _mm256_srlv_epi64(x, _mm256_sub_epi64(_mm256_setzero_si256(), shift)));
}

__m256i less_unsigned(const __m256i& a, const __m256i& b) {
  const __m256i top = _mm256_set1_epi64x(static_cast<std::int64_t>(1ull << 63));
  return _mm256_cmpgt_epi64(_mm256_xor_si256(b, top), _mm256_xor_si256(a, top));
}

// ExactSum::add of four. Lanes are in the order 0, 2, 1, 3, which is that of sums taken apart.
void add_together(ExactSum* sums, const float* x) {
  const __m128i four = _mm_loadu_si128(reinterpret_cast<const __m128i*>(x));
  const __m256i raw = _mm256_cvtepu32_epi64(_mm_shuffle_epi32(four, _MM_SHUFFLE(3, 1, 2, 0)));
  const __m256i exponent = _mm256_and_si256(_mm256_srli_epi64(raw, 23), _mm256_set1_epi64x(0xff));
  const __m256i mantissa = _mm256_or_si256(_mm256_and_si256(raw, _mm256_set1_epi64x(0x7fffff)), _mm256_set1_epi64x(0x800000));
  const __m256i sign = _mm256_sub_epi64(_mm256_setzero_si256(), _mm256_srli_epi64(raw, 31));
  const __m256i shift = _mm256_sub_epi64(exponent, _mm256_set1_epi64x(86));
  __m256i low = shifted(mantissa, shift);
  __m256i high = shifted(mantissa, _mm256_sub_epi64(shift, _mm256_set1_epi64x(64)));
  // Negative ones: −x = ~x + 1, which carries where the low bits were 0.
  low = _mm256_sub_epi64(_mm256_xor_si256(low, sign), sign);
  const __m256i carry = _mm256_and_si256(sign, _mm256_cmpeq_epi64(low, _mm256_setzero_si256()));
  high = _mm256_sub_epi64(_mm256_xor_si256(high, sign), carry);

  auto* at = reinterpret_cast<__m256i*>(sums);
  const __m256i a = _mm256_loadu_si256(at), b = _mm256_loadu_si256(at + 1);
  const __m256i sum_low = _mm256_add_epi64(_mm256_unpacklo_epi64(a, b), low);
  const __m256i sum_high = _mm256_sub_epi64(_mm256_add_epi64(_mm256_unpackhi_epi64(a, b), high), less_unsigned(sum_low, low));
  _mm256_storeu_si256(at, _mm256_unpacklo_epi64(sum_low, sum_high));
  _mm256_storeu_si256(at + 1, _mm256_unpackhi_epi64(sum_low, sum_high));
}

// ExactSquareSum::add_square of four, in the order 0, 3, 2, 1 in which the words of their sums are put together.
void add_squares_together(ExactSquareSum* sums, const float* x) {
  const __m128 four = _mm_loadu_ps(x);
  const __m256d wide = _mm256_cvtps_pd(_mm_shuffle_ps(four, four, _MM_SHUFFLE(1, 2, 3, 0)));
  const __m256i raw = _mm256_castpd_si256(_mm256_mul_pd(wide, wide));
  const __m256i mantissa = _mm256_or_si256(_mm256_and_si256(raw, _mm256_set1_epi64x(0xfffffffffffff)),
                                           _mm256_set1_epi64x(0x10000000000000));
  const __m256i shift = _mm256_sub_epi64(_mm256_srli_epi64(raw, 52), _mm256_set1_epi64x(1075 - 96));
  const __m256i low = shifted(mantissa, shift);
  const __m256i middle = shifted(mantissa, _mm256_sub_epi64(shift, _mm256_set1_epi64x(64)));
  const __m256i high = shifted(mantissa, _mm256_sub_epi64(shift, _mm256_set1_epi64x(128)));

  // Three words each: 0 0 0 1, 1 1 2 2, 2 3 3 3.
  auto* at = reinterpret_cast<__m256i*>(sums);
  const __m256i a = _mm256_loadu_si256(at), b = _mm256_loadu_si256(at + 1), c = _mm256_loadu_si256(at + 2);
  constexpr int kFromB = 0b0011'0000, kFromC = 0b0000'1100;
  const auto pick = [](const __m256i& p, const __m256i& q, const __m256i& r) {
    return _mm256_blend_epi32(_mm256_blend_epi32(p, q, kFromB), r, kFromC);
  };
  __m256i first = pick(a, b, c);                                                                     // 0 3 2 1
  __m256i second = _mm256_permute4x64_epi64(pick(b, c, a), _MM_SHUFFLE(0, 3, 2, 1));   // 1 0 3 2
  __m256i third = _mm256_permute4x64_epi64(pick(c, a, b), _MM_SHUFFLE(1, 0, 3, 2));    // 2 1 0 3
  first = _mm256_add_epi64(first, low);
  const __m256i carry = less_unsigned(first, low);
  second = _mm256_sub_epi64(second, carry);
  third = _mm256_sub_epi64(third, _mm256_and_si256(carry, _mm256_cmpeq_epi64(second, _mm256_setzero_si256())));
  second = _mm256_add_epi64(second, middle);
  third = _mm256_sub_epi64(_mm256_add_epi64(third, high), less_unsigned(second, middle));
  second = _mm256_permute4x64_epi64(second, _MM_SHUFFLE(2, 1, 0, 3));
  third = _mm256_permute4x64_epi64(third, _MM_SHUFFLE(1, 0, 3, 2));
  _mm256_storeu_si256(at, pick(first, third, second));
  _mm256_storeu_si256(at + 1, pick(second, first, third));
  _mm256_storeu_si256(at + 2, pick(third, second, first));
}
#else
constexpr std::size_t kTogether = 1;

void add_together(ExactSum* sum, const float* x) { sum->add(*x); }
void add_squares_together(ExactSquareSum* sum, const float* x) { sum->add_square(*x); }
#endif

}  // namespace

void add(ExactSum* sums, const float* x, std::size_t count) {
  std::size_t i = 0;
  for (; i + kTogether <= count; i += kTogether) add_together(sums + i, x + i);
  for (; i < count; ++i) sums[i].add(x[i]);
}

void add_squares(ExactSquareSum* sums, const float* x, std::size_t count) {
  std::size_t i = 0;
  for (; i + kTogether <= count; i += kTogether) add_squares_together(sums + i, x + i);
  for (; i < count; ++i) sums[i].add_square(static_cast<double>(x[i]));
}

void values(const ExactSum* sums, double* x, std::size_t count) {
  using Word [[gnu::may_alias]] = std::uint64_t;
  const auto* words = reinterpret_cast<const Word*>(sums);
  for (std::size_t i = 0; i < count; ++i) {   // without branches or wide integers: several at a time
    const std::uint64_t low = words[2 * i], high = words[2 * i + 1];
    const std::uint64_t sign = -(high >> 63);   // all bits or none
    const std::uint64_t magnitude = (low ^ sign) - sign;
    const std::uint64_t carry = magnitude == 0 ? sign : 0;
    const double value = to_double((high ^ sign) - carry) + to_double(magnitude) * 0x1p-64;
    x[i] = std::bit_cast<double>(std::bit_cast<std::uint64_t>(value) | sign << 63);
  }
}

void values(const ExactSquareSum* sums, double* x, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) x[i] = sums[i].value();
}

}  // namespace photond
