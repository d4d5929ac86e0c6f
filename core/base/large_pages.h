#pragma once

#include <cstddef>

namespace photond {

/// The size of a large page: of less, take none.
inline constexpr std::size_t kLargePage = std::size_t{1} << 21;

struct LargePages {
  void* memory = nullptr;   ///< on a large page where the system gives any
  std::size_t bytes = 0;    ///< a multiple of kLargePage
};

/// Uninitialized memory of at least so many bytes. What is given back is taken again first: to touch fresh pages took a
/// fifth of the time of indexing photons. Thread-safe. Throws std::bad_alloc.
LargePages take_large_pages(std::size_t bytes);

/// Keeps at most 64 MB for whoever takes some next; the system gets the rest.
void give_large_pages(LargePages pages) noexcept;

}  // namespace photond
