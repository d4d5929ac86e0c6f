#pragma once

#include <mutex>
#include <utility>

namespace photond {

/// A value that many threads change and look at.
template <class Value>
class Guarded {
 public:
  explicit Guarded(Value value = {}) : value_(std::move(value)) {}

  template <class Change>
  void change(const Change& change) {
    const std::lock_guard lock(mutex_);
    change(value_);
  }
  Value get() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }

 private:
  mutable std::mutex mutex_;
  Value value_;
};

}  // namespace photond
