#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/parallel.h"
#include "server/jobs/event_log.h"
#include "server/jobs/job.h"
#include "server/jobs/map_cache.h"
#include "server/jobs/prewarm.h"
#include "server/jobs/run_job.h"
#include "server/jobs/scene_library.h"
#include "server/jobs/scheduler.h"
#include "server/store/store.h"

namespace photond {

/// Budgets and limits of the work; see ServiceOptions.
struct JobLimits {
  int threads = 0;
  std::uint64_t map_cache_bytes = 1ull << 30;
  std::uint64_t scene_cache_bytes = 1ull << 30;
  std::uint64_t picture_bytes = 1ull << 30;
  std::uint64_t max_pixels = 8'388'608;
  int max_live_jobs = 256;
  int max_kept_jobs = 1024;
};

/// Everything that happens behind the HTTP interface, in native types. Thread-safe.
class Jobs {
 public:
  /// `files` may be null: photon maps are kept in memory only.
  Jobs(Store& store, const JobLimits& limits, std::unique_ptr<MapFiles> files);
  ~Jobs();

  SceneLibrary& scenes() { return scenes_; }
  MapCache& maps() { return maps_; }
  const MapCache& maps() const { return maps_; }
  const EventLog& events() const { return log_; }
  const JobLimits& limits() const { return limits_; }
  int threads() const { return workers_.threads(); }
  /// Rendered since the start, over all jobs.
  std::uint64_t passes() const { return passes_; }

  /// Checks a job without running it: scene, camera, settings, limits. Errors name the field ("/film/width").
  /// Returns the plan that the scene gets by these settings.
  Result<Plan> check(const JobSpec& spec, std::stop_token stop);
  /// Checks and queues. Errors: as check; limit_exceeded with `where` "queue" while too many jobs are alive;
  /// conflict while shutting down.
  Result<JobRecord> submit(const JobSpec& spec, std::stop_token stop);
  /// Asks a job to end; what computes stops within a second. Errors: not_found, conflict (it has ended).
  Result<JobRecord> cancel(const std::string& id);
  /// Forgets an ended job. Errors: not_found, conflict.
  Status remove(const std::string& id);
  /// Forgets a scene. Errors: not_found; conflict (a sample, or a live job needs it).
  Status remove_scene(const Digest& id);
  struct Prewarmed {
    Digest content;
    std::vector<MapKey> keys;  ///< the guide's first, then by pass
    std::size_t ready = 0;     ///< of them
  };
  /// Has photon maps built, behind the interactive jobs; asking again tells how far it is and queues nothing twice.
  /// Errors: those of the settings and the scene; limit_exceeded with `where` "queue"; conflict while shutting down.
  Result<Prewarmed> prewarm(const PrewarmSpec& spec, std::stop_token stop);
  /// A picture of a job. Errors: not_found, or the encoder's.
  Result<Frames::Bytes> frame(const std::string& id, std::uint32_t revision, FrameFormat format) const;

  /// Refuses new jobs, cancels the running ones and ends the render thread.
  void stop();

 private:
  std::shared_ptr<RunJob> find(const std::string& id) const;
  void forget_oldest();

  Store& store_;
  const JobLimits limits_;
  EventLog log_;
  Workers workers_;
  SceneLibrary scenes_;
  MapCache maps_;
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<RunJob>> runs_;
  std::map<PrewarmSpec, std::shared_ptr<Prewarm>> prewarms_;  ///< not ended, and some that have
  std::stop_source stop_prewarming_;
  bool stopping_ = false;
  std::atomic<std::uint64_t> passes_{0};
  Scheduler scheduler_;  ///< last: its thread uses all of the above
};

}  // namespace photond
