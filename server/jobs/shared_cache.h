#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace photond {

/// A least-recently-used cache of immutable values within a budget of bytes, where each value is built once
/// however many ask for it at the same time. `Value` has a member `memory_bytes`.
///
/// Invariants: a key is absent, being built by exactly one caller, or ready. Values in use outside are merely
/// shared pointers: eviction forgets them here and frees them when the last user lets go. Pinned values are not
/// evicted; a value larger than what they leave of the budget is handed out but not kept.
template <class Key, class Value>
class SharedCache {
 public:
  using Shared = std::shared_ptr<const Value>;
  using Build = std::function<Result<Shared>()>;

  struct Answer {
    Shared value;
    bool hit = false;  ///< found, or built by somebody else meanwhile
  };
  struct Totals {
    std::uint64_t hits = 0;
    std::uint64_t misses = 0;
    std::uint64_t evictions = 0;
    std::uint64_t bytes = 0;
    std::uint64_t pinned_bytes = 0;
    std::uint64_t entries = 0;
  };
  struct Info {
    Key key;
    Shared value;
    std::uint64_t hits = 0;
    double build_seconds = 0;
    std::chrono::system_clock::time_point last_use;
    bool pinned = false;
  };

  explicit SharedCache(std::uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  /// The value of `key`. One caller runs `build`, the others wait for it; where it fails they get its error (where it
  /// throws, which its caller sees, an internal one), but where it was cancelled one of them builds instead. A waiter
  /// returns ErrorCode::cancelled as soon as its own `stop` asks. With `keep` false a value built here is not stored
  /// (nor waited for by others).
  Result<Answer> get_or_build(const Key& key, const Build& build, std::stop_token stop, bool keep = true) {
    std::unique_lock lock(mutex_);
    while (true) {
      const auto found = entries_.find(key);
      if (found == entries_.end()) break;
      if (found->second.value) return touch(found->second);
      if (!keep) break;
      const std::shared_ptr<Flight> flight = found->second.flight;
      if (!landed_.wait(lock, stop, [&] { return flight->landed; })) return cancelled();
      if (flight->value) return note_hit(flight->value);
      if (flight->error.code != ErrorCode::cancelled) return flight->error;
    }
    ++totals_.misses;
    return keep ? build_and_keep(lock, key, build) : build_apart(lock, build);
  }

  /// Forgets a ready value; false where there is none.
  bool erase(const Key& key) {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(key);
    if (found == entries_.end() || !found->second.value) return false;
    drop(found);
    return true;
  }

  /// Keeps a ready value from eviction, or no longer; false where there is none.
  bool pin(const Key& key, bool pinned) {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(key);
    if (found == entries_.end() || !found->second.value) return false;
    set_pinned(found->second, pinned);
    return true;
  }

  Totals totals() const {
    const std::lock_guard lock(mutex_);
    Totals totals = totals_;
    totals.entries = 0;
    for (const auto& [key, entry] : entries_) totals.entries += entry.value ? 1 : 0;
    return totals;
  }

  /// A ready value; nothing where there is none. No use of it.
  std::optional<Info> find(const Key& key) const {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(key);
    if (found == entries_.end() || !found->second.value) return std::nullopt;
    return info_of(*found);
  }

  /// Ready values in the order of their keys.
  std::vector<Info> list() const {
    const std::lock_guard lock(mutex_);
    std::vector<Info> infos;
    for (const auto& entry : entries_) {
      if (entry.second.value) infos.push_back(info_of(entry));
    }
    return infos;
  }

  std::uint64_t budget_bytes() const { return budget_bytes_; }

 private:
  struct Flight {
    bool landed = false;
    Shared value;
    Error error{ErrorCode::internal, "what is needed here could not be built", ""};  ///< unless the builder tells its own
  };
  struct Entry {
    Shared value;                    ///< null while being built
    std::shared_ptr<Flight> flight;  ///< null once ready
    std::uint64_t tick = 0;          ///< of the last use, for the order of eviction
    std::uint64_t hits = 0;
    double build_seconds = 0;
    std::chrono::system_clock::time_point last_use;
    bool pinned = false;
  };
  using Entries = std::map<Key, Entry>;

  static Info info_of(const typename Entries::value_type& of) {
    const auto& [key, entry] = of;
    return {key, entry.value, entry.hits, entry.build_seconds, entry.last_use, entry.pinned};
  }

  Answer touch(Entry& entry) {
    entry.tick = ++tick_;
    entry.last_use = std::chrono::system_clock::now();
    ++entry.hits;
    return note_hit(entry.value);
  }

  Answer note_hit(Shared value) {
    ++totals_.hits;
    return {std::move(value), true};
  }

  Result<Answer> build_apart(std::unique_lock<std::mutex>& lock, const Build& build) {
    lock.unlock();
    Result<Shared> built = build();
    if (!built) return built.error();
    return Answer{std::move(*built), false};
  }

  Result<Answer> build_and_keep(std::unique_lock<std::mutex>& lock, const Key& key, const Build& build) {
    const auto flight = std::make_shared<Flight>();
    entries_[key].flight = flight;
    lock.unlock();
    const auto begin = std::chrono::steady_clock::now();
    const Result<Shared> built = build_or_land(lock, key, *flight, build);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    lock.lock();
    flight->landed = true;
    landed_.notify_all();
    if (!built) {
      entries_.erase(key);
      flight->error = built.error();
      return built.error();
    }
    flight->value = built.value();
    settle(key, built.value(), seconds.count());
    return Answer{built.value(), false};
  }

  /// What `build` throws, out of memory most likely, must not leave others waiting for ever.
  Result<Shared> build_or_land(std::unique_lock<std::mutex>& lock, const Key& key, Flight& flight, const Build& build) {
    try {
      return build();
    } catch (...) {
      lock.lock();
      flight.landed = true;
      landed_.notify_all();
      entries_.erase(key);
      throw;
    }
  }

  void settle(const Key& key, const Shared& value, double seconds) {
    if (value->memory_bytes > budget_bytes_ - std::min(totals_.pinned_bytes, budget_bytes_)) {
      entries_.erase(key);
      return;
    }
    Entry& entry = entries_[key];
    entry.value = value;
    entry.flight.reset();
    entry.tick = ++tick_;
    entry.build_seconds = seconds;
    entry.last_use = std::chrono::system_clock::now();
    totals_.bytes += value->memory_bytes;
    while (totals_.bytes > budget_bytes_) evict_oldest();
  }

  void evict_oldest() {
    auto oldest = entries_.end();
    for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
      if (!entry->second.value || entry->second.pinned) continue;
      if (oldest == entries_.end() || entry->second.tick < oldest->second.tick) oldest = entry;
    }
    ++totals_.evictions;
    drop(oldest);
  }

  void set_pinned(Entry& entry, bool pinned) {
    if (entry.pinned == pinned) return;
    entry.pinned = pinned;
    totals_.pinned_bytes += pinned ? entry.value->memory_bytes : -entry.value->memory_bytes;
  }

  void drop(typename Entries::iterator entry) {
    set_pinned(entry->second, false);
    totals_.bytes -= entry->second.value->memory_bytes;
    entries_.erase(entry);
  }

  const std::uint64_t budget_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable_any landed_;
  Entries entries_;
  Totals totals_;
  std::uint64_t tick_ = 0;
};

}  // namespace photond
