// Morton 1966: the order. A radix sort from the most significant digit down stops where a cell holds few photons, so
// its cost does not grow with the length of the codes.
#include "core/photon/morton_order.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "core/photon/photon_lanes.h"

namespace photond {

namespace {

constexpr int kPlaceBits = 32;
constexpr int kCodeBits = MortonGrid::kPartBits;         // above the place: keys are compared with their sign
constexpr int kTop = kPlaceBits + kCodeBits;
constexpr int kMostDigitBits = 9;                        // three an axis
constexpr std::uint32_t kMostBuckets = 1u << kMostDigitBits;
// Of fewer photons digits are of two bits an axis: most of more counters would count nothing.
constexpr std::uint32_t kManyForDigit = 512;
// Up to here counting who comes before is faster than another pass over the digits' counters.
constexpr std::uint32_t kFew = 32;
// Photons of a task; fewer are sorted by one thread.
constexpr std::uint32_t kTask = 16'384;

using Counts = std::array<std::uint32_t, kMostBuckets>;

// Of the keys' bits below `top`.
struct Digit {
  int shift;
  std::uint32_t buckets;

  Digit(int top, std::uint32_t n) {
    const int bits = std::min(top - kPlaceBits, n < kManyForDigit ? 6 : kMostDigitBits);
    shift = top - bits;
    buckets = 1u << bits;
  }
  std::uint32_t of(const PhotonKey& key) const { return static_cast<std::uint32_t>(key.bits >> shift) & (buckets - 1); }
};

// Each key's place is the number of those before it, four counted at once. No two are equal. Counts beyond n are of
// anything, and left out.
void sort_few(const PhotonKey* from, std::uint32_t n, PhotonKey* to) {
  using Four = std::int64_t __attribute__((vector_size(32)));
  std::array<PhotonKey, kFew> keys;
  std::copy(from, from + n, keys.begin());
  for (std::uint32_t first = 0; first < n; first += 4) {
    Four mine, before{};
    std::memcpy(&mine, &keys[first], sizeof mine);
    for (std::uint32_t i = 0; i < n; ++i) before -= static_cast<std::int64_t>(keys[i].bits) < mine;
    for (std::uint32_t i = first; i < std::min(n, first + 4); ++i) to[before[i - first]] = keys[i];
  }
}

// Two arrays of equal size between which the passes go to and fro.
struct Buffers {
  PhotonKey* from;
  PhotonKey* to;
  bool ends_in_to;         // where the sorted keys are wanted

  Buffers next(std::uint32_t begin) const { return {to + begin, from + begin, !ends_in_to}; }
};

void finish(const Buffers& buffers, std::uint32_t n) {
  if (buffers.ends_in_to) std::copy(buffers.from, buffers.from + n, buffers.to);
}

// body(task, begin, end) for tasks that are all of n.
template <class Body>
void for_tasks(std::uint32_t n, const Execution& execution, const Body& body) {
  parallel_for(execution, (n + kTask - 1) / kTask, 1, [&](std::size_t task) {
    const auto begin = static_cast<std::uint32_t>(task) * kTask;
    body(task, begin, std::min(n, begin + kTask));
  });
}

class Sorter {
 public:
  Sorter(PhotonSpans photons, const MortonGrid& grid, const Execution& execution)
      : photons_(photons), grid_(grid), execution_(execution) {}

  // Sets the keys of all photons as they stand, `from`, and sorts them.
  void order(const Buffers& buffers, std::uint32_t n, int levels) const {
    std::vector<std::uint32_t> first(photons_.size());
    for (std::size_t span = 1; span < first.size(); ++span) {
      first[span] = first[span - 1] + static_cast<std::uint32_t>(photons_[span - 1].size());
    }
    parallel_for(execution_, photons_.size(), 8, [&](std::size_t span) {
      PhotonKey* keys = buffers.from + first[span];
      std::uint64_t place = span << PhotonKey::kOffsetBits;
      for_parts(photons_[span], grid_, levels, [&](const Photon&, std::uint32_t part) {
        (keys++)->bits = std::uint64_t{part} << kPlaceBits | place++;
      });
    });
    sort(buffers, n, kTop);
  }

 private:
  // Sorts by the first bits in which codes differ.
  void order_by_later_bits(const Buffers& buffers, std::uint32_t n) const {
    std::atomic<std::uint64_t> differing = 0;
    const auto code_of = [&](std::uint32_t i) { return grid_.code(buffers.from[i].of(photons_).position); };
    const std::uint64_t one = code_of(0);
    for_tasks(n, execution_, [&](std::size_t, std::uint32_t begin, std::uint32_t end) {
      std::uint64_t bits = 0;
      for (std::uint32_t i = begin; i < end; ++i) {
        buffers.to[i].bits = code_of(i);
        bits |= buffers.to[i].bits ^ one;
      }
      differing |= bits;
    });
    if (differing == 0) return finish(buffers, n);
    const int left = std::countl_zero(differing.load());
    for_tasks(n, execution_, [&](std::size_t, std::uint32_t begin, std::uint32_t end) {
      for (std::uint32_t i = begin; i < end; ++i) {
        const std::uint64_t code = buffers.to[i].bits << left >> (64 - kCodeBits);
        buffers.from[i].bits = code << kPlaceBits | static_cast<std::uint32_t>(buffers.from[i].bits);
      }
    });
    sort(buffers, n, kTop);
  }

  // By the bits below `top`.
  void sort(const Buffers& buffers, std::uint32_t n, int top) const {
    if (n <= kFew) {
      sort_few(buffers.from, n, buffers.ends_in_to ? buffers.to : buffers.from);
    } else if (top == kPlaceBits) {
      if (!execution_.cancelled()) order_by_later_bits(buffers, n);
    } else if (n <= kTask) {
      sort_serially(buffers, n, top);
    } else {
      sort_in_parallel(buffers, n, top);
    }
  }

  void sort_serially(const Buffers& buffers, std::uint32_t n, int top) const {
    const Digit digit(top, n);
    Counts counts;
    const std::span ends = std::span(counts).first(digit.buckets);
    std::ranges::fill(ends, 0);
    for (std::uint32_t i = 0; i < n; ++i) ++ends[digit.of(buffers.from[i])];
    if (ends[digit.of(buffers.from[0])] == n) return sort(buffers, n, digit.shift);
    std::uint32_t sum = 0;
    for (std::uint32_t& count : ends) sum += std::exchange(count, sum);
    for (std::uint32_t i = 0; i < n; ++i) buffers.to[ends[digit.of(buffers.from[i])]++] = buffers.from[i];
    std::uint32_t begin = 0;
    for (const std::uint32_t end : ends) {
      if (end > begin) sort(buffers.next(begin), end - begin, digit.shift);
      begin = end;
    }
  }

  void sort_in_parallel(const Buffers& buffers, std::uint32_t n, int top) const {
    const Digit digit(top, n);
    std::vector<Counts> places((n + kTask - 1) / kTask);
    for_tasks(n, execution_, [&](std::size_t task, std::uint32_t begin, std::uint32_t end) {
      for (std::uint32_t i = begin; i < end; ++i) ++places[task][digit.of(buffers.from[i])];
    });
    // Bucket by bucket, and within a bucket task by task: equal digits keep their order.
    Counts ends{};
    std::uint32_t sum = 0;
    for (std::uint32_t bucket = 0; bucket < digit.buckets; ++bucket) {
      for (Counts& counts : places) sum += std::exchange(counts[bucket], sum);
      ends[bucket] = sum;
    }
    for_tasks(n, execution_, [&](std::size_t task, std::uint32_t begin, std::uint32_t end) {
      for (std::uint32_t i = begin; i < end; ++i) {
        buffers.to[places[task][digit.of(buffers.from[i])]++] = buffers.from[i];
      }
    });
    parallel_for(execution_, digit.buckets, 1, [&](std::size_t bucket) {
      const std::uint32_t begin = bucket == 0 ? 0 : ends[bucket - 1];
      if (ends[bucket] > begin) sort(buffers.next(begin), ends[bucket] - begin, digit.shift);
    });
  }

  PhotonSpans photons_;
  const MortonGrid& grid_;
  const Execution& execution_;
};

}  // namespace

LargeArray<PhotonKey> morton_order(PhotonSpans photons, const MortonGrid& grid, int levels, const Execution& execution) {
  std::uint32_t n = 0;
  for (const auto& span : photons) n += static_cast<std::uint32_t>(span.size());
  auto keys = make_large_array<PhotonKey>(n);
  const auto scratch = make_large_array<PhotonKey>(n);
  if (n > 0) Sorter(photons, grid, execution).order({keys.get(), scratch.get(), false}, n, levels);
  return keys;
}

}  // namespace photond
