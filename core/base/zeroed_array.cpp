#include "core/base/zeroed_array.h"

#include <cstring>
#include <new>

#include <sys/mman.h>

namespace photond {
namespace {

// Two large pages: of less the allocator keeps what was given back, which is sooner had than pages of the system. It is
// written at once: small pages that are read before they are written, as sums are, fault twice, and the second time
// every other thread is interrupted.
constexpr std::size_t kFromSystem = std::size_t{4} << 20;

}  // namespace

void* take_zeroed(std::size_t bytes) {
  if (bytes == 0) return nullptr;
  if (bytes < kFromSystem) return std::memset(::operator new(bytes), 0, bytes);
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  madvise(memory, bytes, MADV_HUGEPAGE);  // a wish: a kernel without large pages refuses it, and small ones serve
  return memory;
}

void give_back(void* memory, std::size_t bytes) noexcept {
  if (bytes < kFromSystem) {
    ::operator delete(memory);
  } else {
    munmap(memory, bytes);
  }
}

}  // namespace photond
