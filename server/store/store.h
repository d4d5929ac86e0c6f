#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/store/records.h"

namespace photond {

/// What the service remembers. Implementations are thread-safe; every call is one transaction.
class Store {
 public:
  virtual ~Store() = default;

  /// Adds a scene with its bytes; one of the same id is left as it is. Errors: limit_exceeded, io.
  virtual Status put_scene(const SceneRecord& scene, Blob bytes) = 0;
  virtual std::optional<SceneRecord> scene(const Digest& id) const = 0;
  /// Null where there is no such scene.
  virtual Blob scene_bytes(const Digest& id) const = 0;
  /// Samples first, then in the order of arrival.
  virtual std::vector<SceneRecord> scenes() const = 0;
  virtual bool remove_scene(const Digest& id) = 0;

  /// Stores a new job, gives it its sequence number, and appends the event. Returns the event with its id.
  virtual Result<Event> add_job(JobRecord& job, Event event) = 0;
  /// Stores a job's new version together with the event that tells of it.
  virtual Result<Event> update_job(const JobRecord& job, Event event) = 0;
  virtual std::optional<JobRecord> job(const std::string& id) const = 0;
  /// Newest first.
  virtual std::vector<JobRecord> jobs() const = 0;
  /// Removes a job and its events.
  virtual bool remove_job(const std::string& id) = 0;

  /// Events with an id above `after`, ascending, of one job or (empty) of all. State events are kept as long
  /// as their job; of the others the newest few hundred per job.
  virtual std::vector<Event> events_after(std::uint64_t after, const std::string& job) const = 0;
};

}  // namespace photond
