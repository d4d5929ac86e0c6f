#pragma once

#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>

namespace photond {

/// The idempotency keys whose requests are being answered. Thread-safe.
class Underway {
 public:
  /// Held until the last copy goes; null while another request of this key is. Must not outlive the object.
  std::shared_ptr<void> take(const std::string& owner, const std::string& key) {
    std::pair name(owner, key);
    const std::lock_guard lock(mutex_);
    if (!keys_.insert(name).second) return nullptr;
    return std::shared_ptr<void>(this, [this, name = std::move(name)](void*) {
      const std::lock_guard unlock(mutex_);
      keys_.erase(name);
    });
  }

 private:
  std::mutex mutex_;
  std::set<std::pair<std::string, std::string>> keys_;
};

}  // namespace photond
