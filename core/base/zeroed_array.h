#pragma once

#include <algorithm>
#include <cstddef>
#include <type_traits>
#include <utility>

namespace photond {

/// Bytes that are all zero, aligned for any type. Many are fresh pages of the system, of 2 MiB where it has them: each
/// costs memory and time only when it is touched first, by the thread that does so. Throws std::bad_alloc.
void* take_zeroed(std::size_t bytes);

/// What take_zeroed(bytes) gave; null is allowed.
void give_back(void* memory, std::size_t bytes) noexcept;

/// A fixed number of values whose bits are all zero at first, made in no time: for the large arrays of a film, which a
/// single thread would take seconds to fill. T's value with all bits zero must be the T{} that one expects.
template <class T>
class ZeroedArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  using value_type = T;

  ZeroedArray() = default;
  explicit ZeroedArray(std::size_t size) : data_(static_cast<T*>(take_zeroed(size * sizeof(T)))), size_(size) {}
  ZeroedArray(const ZeroedArray& other) : ZeroedArray(other.size_) { std::copy_n(other.data_, size_, data_); }
  ZeroedArray(ZeroedArray&& other) noexcept { swap(other); }
  ZeroedArray& operator=(ZeroedArray other) noexcept {
    swap(other);
    return *this;
  }
  ~ZeroedArray() { give_back(data_, size_ * sizeof(T)); }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  T* begin() { return data_; }
  T* end() { return data_ + size_; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }
  bool operator==(const ZeroedArray& other) const { return std::equal(begin(), end(), other.begin(), other.end()); }

 private:
  void swap(ZeroedArray& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
  }

  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace photond
