#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>
#include <vector>

#include "server/store/blobs.h"
#include "server/store/database.h"
#include "server/store/records.h"

namespace photond {

/// What the service remembers of scenes and jobs. The database is the truth; a copy of its records in memory answers
/// every question, so that readers wait for no disk. Each change is one transaction, and when it returns it is on the
/// disk: only progress events may be lost with the power (never with the process), since nothing but a picture's
/// progress bar depends on them and waiting for the disk twice a second for each job would cost more than it gives.
/// Thread-safe.
class Store {
 public:
  /// `database` must have the tables of schema() and outlive the store; the scenes' files are kept in `scene_files`.
  /// Errors: io.
  static Result<std::unique_ptr<Store>> open(Database& database, const std::filesystem::path& scene_files);

  /// Adds a scene with its bytes; one of the same id is left as it is, but becomes a sample where this one is.
  /// Errors: limit_exceeded at "disk", also where its owner's uploads would exceed `owner_bytes`; io.
  Status put_scene(const SceneRecord& scene, const std::vector<std::byte>& bytes,
                   const std::optional<std::uint64_t>& owner_bytes = {});
  std::optional<SceneRecord> scene(const Digest& id) const;
  /// Errors: not_found, where there is no such scene or its file was damaged: then the scene is gone and may be added
  /// again.
  Result<Blob> scene_bytes(const Digest& id);
  /// The same as a file, of which nothing is kept in memory.
  Result<FileBytes> scene_file(const Digest& id);
  /// Samples first, then in the order of arrival.
  std::vector<SceneRecord> scenes() const;
  /// Removing what is not there is no error.
  Status remove_scene(const Digest& id);
  /// Names a scene that has no name. Errors: io.
  Status name_scene(const Digest& id, const std::string& name);
  const Blobs& scene_files() const { return *files_; }

  /// Stores a new job, gives it its sequence number, and appends the event. Returns the event with its id. `also`
  /// runs in the same transaction.
  Result<Event> add_job(JobRecord& job, Event event, const Database::Body& also = {});
  /// Stores a job's new version together with the event that tells of it. Errors: not_found; those of the disk.
  Result<Event> update_job(const JobRecord& job, Event event);
  std::optional<JobRecord> job(const std::string& id) const;
  /// Newest first.
  std::vector<JobRecord> jobs() const;
  /// Removes a job with its events and whatever rows refer to it. Returns the event that says so. Errors: not_found;
  /// those of the disk.
  Result<Event> remove_job(const std::string& id);

  /// Events with an id above `after`, ascending, of one job or (empty) of all: of each job its state events (the
  /// newest few hundred), its newest progress and its newest frame event; of the newest thousand that are gone, that.
  std::vector<Event> events_after(std::uint64_t after, const std::string& job) const;
  /// Whether it is one of these that are gone.
  bool is_gone(const std::string& job) const;
  /// The id of the newest event; those of an earlier life of the service are lower.
  std::uint64_t newest_event() const;

 private:
  struct StoredJob {
    JobRecord record;
    std::deque<Event> events;
  };

  Store(Database& database, std::unique_ptr<Blobs> files) : database_(database), files_(std::move(files)) {}
  Status load();
  Status load_scenes(Transaction& transaction);
  Status load_jobs(Transaction& transaction);
  Status load_gone(Transaction& transaction);
  Status forget_samples();
  template <class Bytes>
  Result<Bytes> read_scene(const Digest& id, Result<Bytes> (Blobs::*read)(const Digest&));
  Status give_id(Transaction& transaction, Event& event) const;
  Status insert_event(Transaction& transaction, Event& event, const StoredJob* job);
  Status insert_gone(Transaction& transaction, Event& event) const;
  void note_given(std::uint64_t event);
  static void keep(StoredJob& job, Event event);

  Database& database_;
  const std::unique_ptr<Blobs> files_;
  std::mutex writing_;                ///< held over a transaction and the change of the copy
  mutable std::shared_mutex copy_;    ///< held while the copy below is looked at or changed
  std::map<Digest, SceneRecord> scenes_;
  std::map<std::string, StoredJob> jobs_;
  std::deque<Event> gone_;            ///< of jobs that are gone, ascending
  std::uint64_t next_arrival_ = 1;
  std::uint64_t last_sequence_ = 0;
  std::uint64_t last_event_ = 0;      ///< given
  std::uint64_t reserved_events_ = 0; ///< may be given without telling the database
};

}  // namespace photond
