#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <type_traits>

#include "core/base/large_pages.h"

namespace photond {

/// Frees memory of its own, or lets go of what it is part of.
struct FreeMemory {
  std::shared_ptr<const void> owner;
  std::size_t page_bytes = 0;   ///< of large pages
  void operator()(void* memory) const {
    if (page_bytes > 0)
      give_large_pages({memory, page_bytes});
    else if (owner == nullptr)
      std::free(memory);
  }
};

/// Memory for many trivial elements.
template <class T>
using LargeArray = std::unique_ptr<T[], FreeMemory>;

/// Of n elements, uninitialized. From two megabytes on it lies on large pages: touching it for the first time and reading
/// it at random cost less.
template <class T>
LargeArray<T> make_large_array(std::size_t n) {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);
  constexpr std::size_t kAlignment = 64;
  const std::size_t bytes = n * sizeof(T);
  if (bytes >= kLargePage) {
    const LargePages pages = take_large_pages(bytes);
    return LargeArray<T>(static_cast<T*>(pages.memory), FreeMemory{nullptr, pages.bytes});
  }
  const std::size_t size = (bytes + kAlignment - 1) / kAlignment * kAlignment;
  void* memory = std::aligned_alloc(kAlignment, size);
  if (memory == nullptr && size > 0) throw std::bad_alloc();
  return LargeArray<T>(static_cast<T*>(memory));
}

/// Elements that are part of what `owner` keeps alive, such as a mapped file. They may be read only.
template <class T>
LargeArray<T> view_large_array(std::span<const T> elements, std::shared_ptr<const void> owner) {
  return LargeArray<T>(const_cast<T*>(elements.data()), FreeMemory{std::move(owner), 0});
}

}  // namespace photond
