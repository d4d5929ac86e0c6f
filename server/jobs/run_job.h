#pragma once

#include <atomic>
#include <chrono>
#include <memory>

#include "core/film/error.h"
#include "core/film/film.h"
#include "core/film/reconstruct.h"
#include "core/render/preview.h"
#include "core/render/render.h"
#include "server/jobs/job.h"
#include "server/jobs/map_cache.h"
#include "server/jobs/revision_rule.h"
#include "server/jobs/scene_library.h"
#include "server/jobs/scheduler.h"
#include "server/jobs/stop_rule.h"

namespace photond {

/// Turns a queued job into a picture: its first slice prepares, every further one renders a pass. Whatever
/// happens, the job ends in a terminal state.
class RunJob : public Slices {
 public:
  /// The references must outlive the run; `passes` counts over all jobs.
  RunJob(std::shared_ptr<Job> job, SceneLibrary& scenes, MapCache& maps, const Workers& workers,
         std::atomic<std::uint64_t>& passes)
      : job_(std::move(job)),
        scenes_(scenes),
        maps_(maps),
        passes_(passes),
        execution_(workers.execution(job_->stop())) {}

  bool step() override;
  /// Ends a job whose slices will not run any more.
  void abandon();

  const std::shared_ptr<Job>& job() const { return job_; }

 private:
  using Clock = std::chrono::steady_clock;

  Status advance();
  Status prepare_task();
  Status publish_preview();
  Status render_next_pass();
  Status finish();
  Status publish(bool result);
  MapSource map_source();
  Status tell_progress();
  bool stop_rule_met() const;
  Progress progress() const;
  void put_numbers(JobRecord& record) const;
  void end_with(const Error& error);
  void release();
  double wall_seconds() const;

  std::shared_ptr<Job> job_;
  SceneLibrary& scenes_;
  MapUse maps_;
  std::atomic<std::uint64_t>& passes_;
  Execution execution_;

  std::shared_ptr<const RenderTask> task_;
  Film film_;
  ErrorEstimate error_;
  RevisionRule rule_;
  Clock::time_point begin_{};
  double compute_seconds_ = 0;
  double told_ = 0;  ///< wall_seconds of the last event
  std::uint32_t revision_ = 0;
  bool previewed_ = false;
};

}  // namespace photond
