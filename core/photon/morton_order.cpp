// Morton 1966: the order. A radix sort from the most significant digit down stops where a cell holds few photons, so
// its cost does not grow with the length of the codes.
#include "core/photon/morton_order.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace photond {

namespace {

constexpr int kDigitBits = 9;                            // three an axis
constexpr int kFirstShift = 3 * MortonGrid::kAxisBits - kDigitBits;
constexpr std::uint32_t kBuckets = 1u << kDigitBits;
// Up to here insertion is faster than another pass over the counters.
constexpr std::uint32_t kInsertion = 32;
// Photons of a task; fewer are sorted by one thread.
constexpr std::uint32_t kTask = 16'384;

using Counts = std::array<std::uint32_t, kBuckets>;

std::uint32_t digit(const PhotonPlace& place, int shift) {
  return static_cast<std::uint32_t>(place.code >> shift) & (kBuckets - 1);
}

void insertion_sort(PhotonPlace* places, std::uint32_t n) {
  for (std::uint32_t i = 1; i < n; ++i) {
    const PhotonPlace place = places[i];
    std::uint32_t j = i;
    for (; j > 0 && places[j - 1].code > place.code; --j) places[j] = places[j - 1];
    places[j] = place;
  }
}

// Two arrays of equal size between which the passes go to and fro.
struct Buffers {
  PhotonPlace* from;
  PhotonPlace* to;
  bool ends_in_to;         // where the sorted places are wanted

  Buffers next(std::uint32_t begin) const { return {to + begin, from + begin, !ends_in_to}; }
};

void finish(const Buffers& buffers, std::uint32_t n) {
  if (buffers.ends_in_to) std::copy(buffers.from, buffers.from + n, buffers.to);
}

// Counts become the places where the buckets begin.
void sum_up(Counts& counts) {
  std::uint32_t sum = 0;
  for (std::uint32_t& count : counts) sum += std::exchange(count, sum);
}

void sort_serially(const Buffers& buffers, std::uint32_t n, int shift) {
  if (n <= kInsertion || shift < 0) {
    if (shift >= 0) insertion_sort(buffers.from, n);
    finish(buffers, n);
    return;
  }
  Counts ends{};
  for (std::uint32_t i = 0; i < n; ++i) ++ends[digit(buffers.from[i], shift)];
  if (ends[digit(buffers.from[0], shift)] == n) return sort_serially(buffers, n, shift - kDigitBits);
  sum_up(ends);
  for (std::uint32_t i = 0; i < n; ++i) buffers.to[ends[digit(buffers.from[i], shift)]++] = buffers.from[i];
  std::uint32_t begin = 0;
  for (const std::uint32_t end : ends) {
    if (end > begin) sort_serially(buffers.next(begin), end - begin, shift - kDigitBits);
    begin = end;
  }
}

void sort(const Buffers& buffers, std::uint32_t n, int shift, const Execution& execution) {
  if (n <= kTask || shift < 0) return sort_serially(buffers, n, shift);
  const std::uint32_t tasks = (n + kTask - 1) / kTask;
  const auto for_task = [&](std::size_t task, const auto& body) {
    const auto begin = static_cast<std::uint32_t>(task) * kTask;
    for (std::uint32_t i = begin; i < std::min(n, begin + kTask); ++i) body(buffers.from[i]);
  };
  std::vector<Counts> places(tasks);
  parallel_for(execution, tasks, 1, [&](std::size_t task) {
    for_task(task, [&, &counts = places[task]](const PhotonPlace& place) { ++counts[digit(place, shift)]; });
  });
  // Bucket by bucket, and within a bucket task by task: equal digits keep their order.
  Counts ends{};
  std::uint32_t sum = 0;
  for (std::uint32_t bucket = 0; bucket < kBuckets; ++bucket) {
    for (Counts& counts : places) sum += std::exchange(counts[bucket], sum);
    ends[bucket] = sum;
  }
  parallel_for(execution, tasks, 1, [&](std::size_t task) {
    for_task(task, [&, &next = places[task]](const PhotonPlace& place) {
      buffers.to[next[digit(place, shift)]++] = place;
    });
  });
  parallel_for(execution, kBuckets, 1, [&](std::size_t bucket) {
    const std::uint32_t begin = bucket == 0 ? 0 : ends[bucket - 1];
    if (ends[bucket] > begin) sort(buffers.next(begin), ends[bucket] - begin, shift - kDigitBits, execution);
  });
}

}  // namespace

LargeArray<PhotonPlace> morton_order(PhotonSpans blocks, const MortonGrid& grid, const Execution& execution) {
  std::vector<std::uint32_t> first(blocks.size());
  std::uint32_t n = 0;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    first[b] = n;
    n += static_cast<std::uint32_t>(blocks[b].size());
  }
  // Left uninitialized: the first to touch their pages are the threads that fill them.
  auto places = make_large_array<PhotonPlace>(n);
  const auto scratch = make_large_array<PhotonPlace>(n);
  parallel_for(execution, blocks.size(), 1, [&](std::size_t b) {
    for (std::uint32_t i = 0; i < blocks[b].size(); ++i) {
      places[first[b] + i] = {grid.code(blocks[b][i].position), static_cast<std::uint32_t>(b), i};
    }
  });
  if (!execution.cancelled()) sort({places.get(), scratch.get(), false}, n, kFirstShift, execution);
  return places;
}

}  // namespace photond
