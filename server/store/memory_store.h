#pragma once

#include <deque>
#include <map>
#include <memory>
#include <mutex>

#include "server/store/store.h"

namespace photond {

/// A store that lives as long as the process.
class MemoryStore : public Store {
 public:
  /// Scenes that are no samples may take `scene_budget_bytes` together.
  explicit MemoryStore(std::uint64_t scene_budget_bytes) : scene_budget_bytes_(scene_budget_bytes) {}

  Status put_scene(const SceneRecord& scene, Blob bytes) override;
  std::optional<SceneRecord> scene(const Digest& id) const override;
  Blob scene_bytes(const Digest& id) const override;
  std::vector<SceneRecord> scenes() const override;
  bool remove_scene(const Digest& id) override;

  Result<Event> add_job(JobRecord& job, Event event) override;
  Result<Event> update_job(const JobRecord& job, Event event) override;
  std::optional<JobRecord> job(const std::string& id) const override;
  std::vector<JobRecord> jobs() const override;
  bool remove_job(const std::string& id) override;

  std::vector<Event> events_after(std::uint64_t after, const std::string& job) const override;

 private:
  struct StoredScene {
    SceneRecord record;
    Blob bytes;
    std::uint64_t order = 0;
  };
  struct StoredJob {
    JobRecord record;
    std::deque<Event> events;
  };
  Event append(StoredJob& job, Event event);

  const std::uint64_t scene_budget_bytes_;
  mutable std::mutex mutex_;
  std::uint64_t scene_bytes_total_ = 0;
  std::uint64_t next_order_ = 1;
  std::uint64_t next_sequence_ = 1;
  std::uint64_t next_event_ = 1;
  std::map<Digest, StoredScene> scenes_;
  std::map<std::string, StoredJob> jobs_;
};

}  // namespace photond
