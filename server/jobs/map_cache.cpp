#include "server/jobs/map_cache.h"

#include <algorithm>
#include <exception>
#include <map>

namespace photond {

namespace {

// Of maps that wait to be written; what comes beyond it stays in memory only.
constexpr std::uint64_t kMaxQueuedBytes = 512ull << 20;
// For what is yet to be written when the service ends; the rest is built again when it is needed.
constexpr std::chrono::seconds kLastWrites{2};

void add_memory(MapCache::Info& info, const SharedCache<MapKey, CachedMap>::Info& entry) {
  info = {.key = entry.key,
          .bytes = entry.value->memory_bytes,
          .facts = entry.value->facts,
          .hits = entry.hits,
          .last_use = entry.last_use,
          .in_memory = true,
          .pinned = entry.pinned};
}

void add_file(MapCache::Info& info, const MapFiles::Info& file) {
  if (!info.in_memory) info = {.key = file.key, .bytes = file.bytes, .facts = file.facts};
  info.hits += file.hits;
  info.last_use = std::max(info.last_use, file.last_use);
  info.on_disk = true;
  info.pinned = info.pinned || file.pinned;
}

}  // namespace

MapCache::MapCache(std::uint64_t memory_bytes, std::unique_ptr<MapFiles> files)
    : files_(std::move(files)), memory_(memory_bytes) {
  if (files_) writer_ = std::jthread([this](std::stop_token stop) { write_all(std::move(stop)); });
}

MapCache::~MapCache() {
  if (flush(kLastWrites)) return;
  const std::lock_guard lock(mutex_);
  queue_.clear();
}

Result<MapCache::Answer> MapCache::get(const PreparedScene& scene, const MapKey& key, const Execution& execution,
                                       bool keep) {
  Origin origin = Origin::memory;
  const auto find_or_build = [&]() -> Result<Memory::Shared> {
    origin = Origin::disk;
    if (Memory::Shared found = read(key, execution)) return found;
    origin = Origin::built;
    return build(scene, key, execution);
  };
  auto answer = memory_.get_or_build(key, find_or_build, execution.stop, keep);
  if (!answer) return answer.error();
  if (answer->hit) origin = Origin::memory;
  if (origin == Origin::disk) {
    ++disk_hits_;
    if (const auto file = files_->find(key); file && file->pinned) memory_.pin(key, true);
  }
  if (origin == Origin::built && keep) write_later(key, answer->value);
  return Answer{std::move(answer->value), origin};
}

Result<MapCache::Memory::Shared> MapCache::build(const PreparedScene& scene, const MapKey& key,
                                                 const Execution& execution) {
  const auto begin = std::chrono::steady_clock::now();
  auto built = std::make_shared<CachedMap>();
  if (is_guide_key(key)) {
    auto guide = build_gather_guide(scene, key, execution);
    if (!guide) return guide.error();
    built->guide = std::move(*guide);
  } else {
    auto maps = build_maps(scene, key, execution);
    if (!maps) return maps.error();
    built->maps = std::move(*maps);
  }
  const PhotonMaps& maps = built->guide ? *built->guide->pilot : *built->maps;
  built->memory_bytes = built->guide ? built->guide->memory_bytes : maps.memory_bytes;
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  built->facts = {maps.global.size(), maps.caustic.size(), seconds.count()};
  return Memory::Shared(std::move(built));
}

// Irradiance is added to the photons of the first pass where they are there already.
Result<std::shared_ptr<const PhotonMaps>> MapCache::build_maps(const PreparedScene& scene, const MapKey& key,
                                                               const Execution& execution) {
  const MapKey plain{key.scene, key.settings, 0};
  if (!is_irradiance_key(key) || !find(plain)) return build_photon_maps(scene, key, execution);
  const auto found = get(scene, plain, execution, false);
  return found ? add_irradiance(scene, key, found->value->maps, execution) : found.error();
}

MapCache::Memory::Shared MapCache::read(const MapKey& key, const Execution& execution) {
  if (!files_) return nullptr;
  const auto info = files_->find(key);
  if (!info) return nullptr;
  SharedSpan file = files_->map(key).value_or(SharedSpan());
  auto found = std::make_shared<CachedMap>();
  found->facts = info->facts;
  if (is_guide_key(key)) {
    found->guide = read_gather_guide(std::move(file), key, execution);
    if (found->guide) found->memory_bytes = found->guide->memory_bytes;
  } else {
    found->maps = read_photon_maps(std::move(file), key, execution);
    if (found->maps) found->memory_bytes = found->maps->memory_bytes;
  }
  if (found->guide || found->maps) return found;
  ++damaged_;
  files_->erase(key);
  return nullptr;
}

void MapCache::write_later(const MapKey& key, Memory::Shared value) {
  if (!files_) return;
  const std::lock_guard lock(mutex_);
  if (queued_bytes_ + value->memory_bytes > kMaxQueuedBytes) return;
  queued_bytes_ += value->memory_bytes;
  queue_.push_back({key, std::move(value)});
  changed_.notify_all();
}

void MapCache::write_all(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return !queue_.empty(); })) {
    const Write next = std::move(queue_.front());
    queue_.pop_front();
    queued_bytes_ -= next.value->memory_bytes;
    writing_ = next.key;
    unwanted_ = false;
    lock.unlock();
    if (!write(next)) ++write_failures_;
    lock.lock();
    if (unwanted_) files_->erase(next.key);
    writing_.reset();
    changed_.notify_all();
  }
}

/// False where it could not be written, as on a full disk or without memory.
bool MapCache::write(const Write& what) {
  try {
    const CachedMap& value = *what.value;
    SectionList list = value.guide ? guide_sections(*value.guide, value.facts.build_seconds)
                                   : map_sections(*value.maps, value.facts.build_seconds);
    const auto pieces = list.pieces(map_identity(what.key), Execution{});
    if (!files_->put(what.key, value.facts, pieces)) return false;
    const auto info = find(what.key);
    if (info && info->pinned) files_->pin(what.key, true);
    return true;
  } catch (const std::exception&) {  // nobody waits for this thread, and it serves all maps to come
    return false;
  }
}

bool MapCache::flush(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, patience, [this] { return queue_.empty() && !writing_; });
}

std::vector<MapCache::Info> MapCache::list() const {
  std::map<MapKey, Info> infos;
  for (const Memory::Info& entry : memory_.list()) add_memory(infos[entry.key], entry);
  for (const MapFiles::Info& file : files_ ? files_->list() : std::vector<MapFiles::Info>())
    add_file(infos[file.key], file);
  std::vector<Info> result;
  for (const auto& [key, info] : infos) result.push_back(info);
  return result;
}

std::optional<MapCache::Info> MapCache::find(const MapKey& key) const {
  const auto entry = memory_.find(key);
  const auto file = files_ ? files_->find(key) : std::nullopt;
  if (!entry && !file) return std::nullopt;
  Info info;
  if (entry) add_memory(info, *entry);
  if (file) add_file(info, *file);
  return info;
}

MapCache::Totals MapCache::totals() const {
  Totals totals;
  totals.memory = memory_.totals();
  totals.disk_hits = disk_hits_;
  totals.misses = totals.memory.misses - std::min(totals.memory.misses, totals.disk_hits);
  if (files_) totals.disk = files_->totals();
  totals.write_failures = write_failures_;
  totals.damaged = damaged_;
  return totals;
}

bool MapCache::erase(const MapKey& key) {
  const std::lock_guard lock(mutex_);
  bool found = memory_.erase(key);
  std::erase_if(queue_, [&](const Write& waiting) {
    if (waiting.key != key) return false;
    queued_bytes_ -= waiting.value->memory_bytes;
    return true;
  });
  if (writing_ == key) unwanted_ = true;
  if (files_) found = files_->erase(key) || found;
  return found;
}

Status MapCache::pin(const MapKey& key, bool pinned) {
  std::uint64_t in_memory = 0, on_disk = 0;
  std::optional<Info> found;
  for (const Info& info : list()) {
    if (info.key == key) found = info;
    if (!info.pinned && info.key != key) continue;
    in_memory += info.bytes;
    on_disk += info.on_disk || info.key == key ? info.bytes : 0;
  }
  if (!found) return Error{ErrorCode::not_found, "there is no photon map of this key", ""};
  if (pinned && (in_memory > memory_budget() / 2 || (files_ && on_disk > disk_budget() / 2))) {
    return Error{ErrorCode::conflict, "pinned maps would take more than half of what maps may take", ""};
  }
  const bool held = memory_.pin(key, pinned);
  const bool filed = files_ && files_->pin(key, pinned);
  if (held || filed) return Done{};
  return Error{ErrorCode::not_found, "there is no photon map of this key", ""};
}

Result<std::shared_ptr<const CachedMap>> MapUse::get(const PreparedScene& scene, const MapKey& key,
                                                     const Execution& execution) {
  const bool keep = kept_bytes_ < cache_.memory_budget() / 4;
  auto answer = cache_.get(scene, key, execution, keep);
  if (!answer) return answer.error();
  ++(answer->origin == MapCache::Origin::built ? misses_ : hits_);
  if (answer->origin == MapCache::Origin::disk) ++disk_hits_;
  if (keep && answer->origin != MapCache::Origin::memory) kept_bytes_ += answer->value->memory_bytes;
  return std::move(answer->value);
}

Result<std::shared_ptr<const PhotonMaps>> MapUse::maps(const PreparedScene& scene, const MapKey& key,
                                                       const Execution& execution) {
  if (last_ && last_->first == key) return last_->second;
  last_.reset();
  auto found = get(scene, key, execution);
  if (!found) return found.error();
  last_.emplace(key, (*found)->maps);
  return (*found)->maps;
}

Result<std::shared_ptr<const GatherGuide>> MapUse::guide(const PreparedScene& scene, const MapKey& key,
                                                         const Execution& execution) {
  auto found = get(scene, key, execution);
  if (!found) return found.error();
  return (*found)->guide;
}

}  // namespace photond
