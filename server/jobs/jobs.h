#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <semaphore>
#include <string>
#include <thread>
#include <vector>

#include "core/base/parallel.h"
#include "server/jobs/disk_room.h"
#include "server/jobs/environment_library.h"
#include "server/jobs/estimate.h"
#include "server/jobs/event_log.h"
#include "server/jobs/job.h"
#include "server/jobs/map_cache.h"
#include "server/jobs/prewarm.h"
#include "server/jobs/run_job.h"
#include "server/jobs/scene_library.h"
#include "server/jobs/scheduler.h"
#include "server/store/job_files.h"
#include "server/store/keys.h"
#include "server/store/store.h"

namespace photond {

/// Budgets and limits of the work; see ServiceOptions.
struct JobLimits {
  int threads = 0;
  std::uint64_t map_cache_bytes = 1ull << 30;
  std::uint64_t scene_cache_bytes = 1ull << 30;
  std::uint64_t max_pixels = 8'388'608;
  std::uint64_t max_job_memory_bytes = UINT64_MAX;
  int max_live_jobs = 256;
  int max_kept_jobs = 1024;
  std::chrono::milliseconds watch_time{30'000};
  std::chrono::milliseconds drain_time{15'000};  ///< for the running jobs to be put away when the service ends
  DiskLimits disk;
};

/// Everything that happens behind the HTTP interface, in native types. Thread-safe.
class Jobs {
 public:
  /// `store`, `environments` and `files`, which are in the folder `data`, must outlive the object.
  /// `maps` may be null: photon maps are kept in memory only.
  Jobs(Store& store, Environments& environments, JobFiles& files, const std::filesystem::path& data,
       IdentityOf identity, const JobLimits& limits, std::unique_ptr<MapFiles> maps);
  ~Jobs();

  /// Takes up what an earlier life of the service left. To be called once, when the scenes are there.
  void recover();

  EnvironmentLibrary& environments() { return environments_; }
  SceneLibrary& scenes() { return scenes_; }
  MapCache& maps() { return maps_; }
  const MapCache& maps() const { return maps_; }
  /// How full the disk is. While it is full or out of reach, running jobs are paused and new ones refused; both ends
  /// by itself.
  DiskRoom& room() { return room_; }
  const DiskRoom& room() const { return room_; }
  /// Jobs that lately had no room on the disk for what they have computed: most of them wait.
  int without_room() const { return without_room_; }
  const EventLog& events() const { return log_; }
  const JobLimits& limits() const { return limits_; }
  int threads() const { return workers_.threads(); }
  /// Rendered since the start, over all jobs.
  std::uint64_t passes() const { return passes_; }

  /// Checks a job without running it: scene, camera, settings, limits, of its memory what settings tell. Errors name the
  /// field ("/film/width").
  /// Returns the plan that the scene gets by these settings.
  Result<Plan> check(const JobSpec& spec, std::stop_token stop);
  /// Checks, and renders a few passes of a small picture to tell what the job would cost; one at a time, beside the
  /// jobs that run, which make it look slower. Errors: as check; limit_exceeded with `where` "queue" while one is at it
  /// and another waits.
  Result<JobEstimate> estimate(const JobSpec& spec, std::stop_token stop);
  /// What shall be stored together with a new job, or not at all.
  using Also = std::function<Status(Transaction&, const JobRecord&)>;
  /// Checks and queues. Errors: as check; limit_exceeded with `where` "queue" while too many jobs are alive, or too
  /// many of the owner's; cancelled while shutting down; those of `also`.
  Result<JobRecord> submit(const JobSpec& spec, const Owner& owner, std::stop_token stop, const Also& also = {});
  /// Each change of a job takes what must hold of it, or nothing; its error, which is no conflict, is the change's.
  using Guard = Job::Guard;
  /// Asks a job to end; what computes stops within a second. Errors: not_found, conflict (it has ended).
  Result<JobRecord> cancel(const std::string& id, const Guard& guard = {});
  /// Puts a job aside until it is resumed; what computes stops within a second and its passes are kept. Again: no
  /// error. Errors: not_found, conflict (it ends or has ended).
  Result<JobRecord> pause(const std::string& id, const Guard& guard = {});
  /// Takes a paused job up again. One that is on its way already: no error. Errors: not_found, conflict.
  Result<JobRecord> resume(const std::string& id, const Guard& guard = {});
  /// Lets a succeeded job go on to a later stop. One that is on its way to that stop, or there: no error. Errors:
  /// not_found; conflict (also where its scene or environment is gone); invalid_input ("/stop/…"; "/stop": met
  /// already); limit_exceeded as submit.
  Result<JobRecord> extend(const std::string& id, const StopRule& stop, const Owner& by, const Guard& guard = {});
  /// Lets a failed job begin again, from its last checkpoint. One that is on its way: no error. Errors: not_found,
  /// conflict (also where its scene or environment is gone), limit_exceeded as submit.
  Result<JobRecord> retry(const std::string& id, const Owner& by, const Guard& guard = {});
  /// Forgets an ended job. Errors: not_found, conflict.
  Status remove(const std::string& id, const Guard& guard = {});
  /// Forgets a scene. Errors: not_found; conflict (a sample, or a live job needs it).
  Status remove_scene(const Digest& id);
  /// Forgets an environment. Errors: not_found; conflict (a live job needs it).
  Status remove_environment(const Digest& id);
  struct Prewarmed {
    Digest content;
    std::vector<MapKey> keys;  ///< the guide's first, then by pass
    std::size_t ready = 0;     ///< of them
  };
  /// Has photon maps built, behind the interactive jobs; asking again tells how far it is and queues nothing twice.
  /// Errors: those of the settings and the scene; limit_exceeded with `where` "queue"; cancelled while shutting down.
  Result<Prewarmed> prewarm(const PrewarmSpec& spec, const std::string& owner, std::stop_token stop);
  /// Ends the prewarming, of this owner only where one is named, that was to build a map which is not there: within a
  /// second, and what it has built so far stays. False where there is none.
  bool cancel_prewarms(const MapKey& key, const std::optional<std::string>& owner);
  /// The job itself, for those who look at it for long; null where there is none.
  std::shared_ptr<const Job> job(const std::string& id) const;

  struct CheckpointFile {
    JobFiles::Checkpoint about;
    FileBytes bytes;
  };
  /// The newest checkpoint: an accumulator file, which `photond merge` takes; of a succeeded job that of all its
  /// passes. Errors: not_found (no such job, or none was written: short jobs have none, nor has one that found no room
  /// for it), io.
  Result<CheckpointFile> checkpoint(const std::string& id) const;
  /// A picture of a job: of the newest ones while it runs, its newest once it rests; of the error where it was kept.
  /// Errors: not_found, or the encoder's.
  Result<Frames::Bytes> frame(const std::string& id, std::uint32_t revision, FrameFormat format,
                              FrameLayer layer = FrameLayer::radiance) const;
  /// The file of a picture that is on the disk already. Errors: not_found, io.
  Result<FileBytes> frame_file(const std::string& id, std::uint32_t revision, FrameFormat format) const;

  /// Refuses new work, puts the running jobs back into the queue with their passes kept, and ends the render thread.
  /// What is not put away after the drain time goes on from its last checkpoint at the next start.
  void stop();
  bool stopping() const { return stopping_; }

 private:
  std::shared_ptr<RunJob> find(const std::string& id) const;
  std::shared_ptr<RunJob> make_run(JobRecord record);
  Status check_room(const Owner& owner) const;
  Status check_needs(const JobSpec& spec) const;
  Result<JobRecord> start_again(const std::string& id, JobState from, const Owner& by, const Job::Edit& edit,
                                const Guard& guard);
  void put_to_work(const std::shared_ptr<RunJob>& run);
  Status forget(const std::string& id);
  Status forget_oldest();
  void keep_house(std::stop_token stop);
  void tidy_up();
  void pause_for(PauseReason reason);
  void wake();
  void count_without_room();

  Store& store_;
  JobFiles& files_;
  const JobLimits limits_;
  EventLog log_;
  DiskRoom room_;
  const Turn turn_;
  Workers workers_;
  EnvironmentLibrary environments_;
  SceneLibrary scenes_;
  MapCache maps_;
  std::counting_semaphore<2> estimates_{2};  ///< under way and waiting
  std::timed_mutex estimating_;
  std::atomic<std::uint64_t> passes_{0};
  const RunParts parts_;
  mutable std::mutex mutex_;  ///< of the maps below, and of what must not happen beside a change of it
  std::map<std::string, std::shared_ptr<RunJob>> runs_;  ///< of every job that is known
  std::map<PrewarmSpec, std::shared_ptr<Prewarm>> prewarms_;  ///< not ended, and some that have
  std::atomic<bool> stopping_ = false;
  std::atomic<int> without_room_ = 0;
  Scheduler scheduler_;  ///< late: its thread uses all of the above
  std::condition_variable_any tick_;
  std::jthread housekeeper_;
};

}  // namespace photond
