#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

#include "core/film/error.h"
#include "core/film/film.h"
#include "core/film/reconstruct.h"
#include "core/render/preview.h"
#include "core/render/render.h"
#include "server/jobs/checkpoint.h"
#include "server/jobs/disk_room.h"
#include "server/jobs/job.h"
#include "server/jobs/map_cache.h"
#include "server/jobs/memory_need.h"
#include "server/jobs/revision_rule.h"
#include "server/jobs/scene_library.h"
#include "server/jobs/scheduler.h"
#include "server/jobs/stop_rule.h"
#include "server/jobs/turn.h"

namespace photond {

/// What determines a picture, and the program, as text: films of the same may be added.
using IdentityOf = std::function<Result<std::string>(const RenderTask&)>;

/// What all runs share. The references must outlive them.
struct RunParts {
  SceneLibrary& scenes;
  MapCache& maps;
  const Workers& workers;
  JobFiles& files;
  DiskRoom& room;
  const Turn& turn;
  std::atomic<std::uint64_t>& passes;  ///< over all jobs
  std::uint64_t max_memory_bytes;      ///< of one job, as check_memory
  IdentityOf identity;
  std::chrono::milliseconds watch_time;  ///< for which pictures are published after somebody has looked
};

/// Turns a queued job into a picture: the first slice prepares, or goes on from a checkpoint, every further one renders
/// a pass. What others want of the job they say by its state (canceling, paused) and `interrupt`; the next slice then
/// puts it away. A run may be put away and taken up again any number of times.
class RunJob : public Slices {
 public:
  RunJob(std::shared_ptr<Job> job, const RunParts& parts);

  bool step() override;
  std::string owner() const override { return job_->owner; }
  bool unseen() const override { return !previewed_ && film_.pass_count() == 0; }
  std::uint64_t memory() const override { return film_memory(job_->spec.settings); }

  /// True where the run is to be given to a scheduler, since it is in none; from then on it counts as in one, until a
  /// `step` has returned false.
  bool claim();
  /// Ends what computes now within a second.
  void interrupt();
  /// As `interrupt`, for good: what would be kept of an interrupted job is not made either.
  void cancel();
  /// As `interrupt`, for an end of the service: the job is put away and goes back to the queue.
  void drain();
  /// Puts a job that an earlier life of the service left unfinished back into the queue.
  Status put_back();
  /// In no scheduler although its job is neither ended nor paused: the store refused to say so.
  bool stalled() const;
  /// Its job rests, but could not be put away, and keeps its memory; a further `step` tries again.
  bool unsaved() const { return unsaved_; }
  /// Bytes that there was no room for when the job's film was last to be written down; 0 where there was.
  std::uint64_t missing_bytes() const { return missing_bytes_; }
  /// From now on the job computes on where there is no room for its film, until there is: a crash costs it more.
  void dare() { dares_ = true; }

  const std::shared_ptr<Job>& job() const { return job_; }

 private:
  using Clock = std::chrono::steady_clock;

  void arm();
  bool rest();
  Status advance();
  Status prepare();
  void add_to_earlier();
  Status make_task();
  Status restore();
  Status publish_preview();
  Status render_next_pass();
  Status finish();
  Status publish(bool result);
  MapSource map_source();
  Status keep_picture(const std::stop_token& stop);
  Status keep_seen_picture();
  Status checkpoint();
  Status checkpoint_if_there_is_room();
  Status tell_progress();
  void take_failure(const Error& error);
  void take_failure_of(const std::function<Status()>& work);
  void settle();
  bool put_away();
  void let_go();
  void release();
  void stall(const Status& refused);
  void measure();
  bool stop_rule_met() const;
  bool is_recent(Clock::time_point look) const { return Clock::now() - look < parts_.watch_time; }
  Progress progress() const;
  /// For what a pause or the end of the service does not interrupt: it tells what the job stops by, or what is shown.
  Execution until_cancelled() const { return {execution_.arena, cancel_.get_token()}; }
  void put_numbers(JobRecord& record) const;
  double wall_seconds() const;

  const std::shared_ptr<Job> job_;
  const RunParts& parts_;
  MapUse maps_;

  std::stop_source cancel_;
  mutable std::mutex mutex_;  ///< of these four, which other threads use
  std::stop_source stop_;
  bool scheduled_ = false;
  bool draining_ = false;
  bool stalled_ = false;
  std::atomic<std::uint64_t> missing_bytes_{0};
  std::atomic<bool> unsaved_{false};
  std::atomic<bool> dares_{false};
  Execution execution_;

  std::shared_ptr<const RenderTask> task_;
  std::string identity_;
  Film film_;
  ErrorEstimate error_;
  std::uint32_t measured_passes_ = 0;  ///< when `error_` was estimated
  std::optional<double> least_error_;  ///< as that of the record
  RevisionRule rule_;
  CheckpointRule checkpoints_;
  bool checkpointed_ = false;            ///< in this life of the service
  std::uint32_t checkpoint_passes_ = 0;  ///< in the newest checkpoint
  std::uint32_t published_passes_ = 0;   ///< in the newest picture
  Clock::time_point begin_{};            ///< of the preparing
  double compute_seconds_ = 0;
  double told_ = 0;  ///< wall_seconds of the last event
  std::uint64_t earlier_hits_, earlier_disk_hits_, earlier_misses_;  ///< of maps, before the job was last taken up
  bool previewed_ = false;
  bool settled_ = false;  ///< the slice has seen that the job is to rest, and put it away
};

}  // namespace photond
