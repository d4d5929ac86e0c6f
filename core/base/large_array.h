#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <type_traits>

#include <sys/mman.h>

namespace photond {

/// Frees memory of its own, or lets go of what it is part of.
struct FreeMemory {
  std::shared_ptr<const void> owner;
  void operator()(void* memory) const {
    if (owner == nullptr) std::free(memory);
  }
};

/// Memory for many trivial elements.
template <class T>
using LargeArray = std::unique_ptr<T[], FreeMemory>;

/// Of n elements, uninitialized. From two megabytes on it lies on huge pages where the system gives any: touching it
/// for the first time and reading it at random cost less.
template <class T>
LargeArray<T> make_large_array(std::size_t n) {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);
  constexpr std::size_t kHugePage = std::size_t{1} << 21;
  const std::size_t bytes = n * sizeof(T);
  const bool huge = bytes >= kHugePage;
  const std::size_t alignment = huge ? kHugePage : 64;
  const std::size_t size = (bytes + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, size);
  if (memory == nullptr && size > 0) throw std::bad_alloc();
  // Advice: nothing depends on whether it is taken.
  if (huge) (void)madvise(memory, size, MADV_HUGEPAGE);
  return LargeArray<T>(static_cast<T*>(memory));
}

/// Elements that are part of what `owner` keeps alive, such as a mapped file. They may be read only.
template <class T>
LargeArray<T> view_large_array(std::span<const T> elements, std::shared_ptr<const void> owner) {
  return LargeArray<T>(const_cast<T*>(elements.data()), FreeMemory{std::move(owner)});
}

}  // namespace photond
