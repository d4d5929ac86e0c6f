#include "core/base/large_pages.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <mutex>
#include <new>
#include <utility>

#include <sys/mman.h>

namespace photond {

namespace {

constexpr std::size_t kMostBytes = std::size_t{64} << 20;

// What nobody uses now, the latest first.
class Kept {
 public:
  // The latest that is large enough and not wasteful; none if there is no such.
  LargePages take(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    const auto end = kept_.begin() + count_;
    const auto found = std::find_if(kept_.begin(), end, [&](const LargePages& pages) {
      return pages.bytes >= bytes && pages.bytes <= bytes + bytes / 4 + kLargePage;
    });
    if (found == end) return {};
    const LargePages result = *found;
    std::move(found + 1, end, found);
    --count_;
    bytes_ -= result.bytes;
    return result;
  }

  // Frees the oldest until there is room.
  void give(LargePages pages) {
    const std::lock_guard lock(mutex_);
    while (count_ > 0 && (bytes_ + pages.bytes > kMostBytes || count_ == static_cast<std::ptrdiff_t>(kept_.size()))) {
      const LargePages& oldest = kept_[static_cast<std::size_t>(--count_)];
      bytes_ -= oldest.bytes;
      std::free(oldest.memory);
    }
    std::move_backward(kept_.begin(), kept_.begin() + count_, kept_.begin() + count_ + 1);
    kept_[0] = pages;
    ++count_;
    bytes_ += pages.bytes;
  }

 private:
  std::mutex mutex_;
  std::array<LargePages, kMostBytes / kLargePage> kept_;
  std::ptrdiff_t count_ = 0;
  std::size_t bytes_ = 0;
};

// Never destroyed: other statics may hold pages.
Kept& kept() {
  static Kept& kept = *new Kept;
  return kept;
}

}  // namespace

LargePages take_large_pages(std::size_t bytes) {
  const std::size_t whole = (bytes + kLargePage - 1) / kLargePage * kLargePage;
  if (const LargePages pages = kept().take(whole); pages.memory != nullptr) return pages;
  void* memory = std::aligned_alloc(kLargePage, whole);
  if (memory == nullptr) throw std::bad_alloc();
  // Advice: nothing depends on whether it is taken.
  (void)madvise(memory, whole, MADV_HUGEPAGE);
  return {memory, whole};
}

void give_large_pages(LargePages pages) noexcept {
  if (pages.bytes <= kMostBytes)
    kept().give(pages);
  else
    std::free(pages.memory);
}

}  // namespace photond
