#include "server/jobs/run_job.h"

#include <algorithm>
#include <exception>
#include <utility>

namespace photond {

namespace {

constexpr double kProgressSeconds = 0.5;  // between two progress events

}  // namespace

bool RunJob::step() {
  Status status = Done{};
  try {
    status = advance();
  } catch (const std::exception& failure) {
    status = Error{ErrorCode::internal, std::string("rendering failed: ") + failure.what(), ""};
  }
  if (!status) end_with(status.error());
  const bool more = !is_terminal(job_->state());
  if (!more) release();
  return more;
}

void RunJob::abandon() {
  end_with(cancelled());
  release();
}

void RunJob::release() {
  film_ = Film();
  maps_.release();
  task_.reset();
}

void RunJob::end_with(const Error& error) {
  const auto numbers = [this](JobRecord& record) { put_numbers(record); };
  if (execution_.cancelled() || job_->state() == JobState::canceling) {
    if (job_->move(JobState::canceled, numbers)) return;
  }
  const auto failure = [&](JobRecord& record) {
    put_numbers(record);
    record.failure = error;
  };
  // A refusal here means that the job has ended meanwhile, which is all that is wanted.
  (void)job_->move(JobState::failed, failure).ok();
}

Status RunJob::advance() {
  if (execution_.cancelled()) return cancelled();
  if (!task_) return prepare_task();
  if (revision_ == 0 && film_.pass_count() == 0 && !previewed_ && has_preview(*task_)) return publish_preview();
  if (const Status rendered = render_next_pass(); !rendered) return rendered;
  if (stop_rule_met()) return finish();
  if (rule_.due(film_.pass_count(), wall_seconds())) return publish(false);
  return wall_seconds() - told_ >= kProgressSeconds ? tell_progress() : Done{};
}

Status RunJob::prepare_task() {
  begin_ = Clock::now();
  if (const Status moved = job_->move(JobState::preparing); !moved) return moved;
  const JobSpec& spec = job_->spec();
  const auto scene = scenes_.prepared(spec.scene, execution_);
  if (!scene) return scene.error();
  const Result<Camera> camera = choose_camera((*scene)->scene.cameras, spec.camera);
  if (!camera) return camera.error();
  Result<RenderTask> task = make_render_task(*scene, *camera, spec.photons, spec.settings, execution_,
                                             [this](const auto&... of) { return maps_.guide(of...); });
  if (!task) return task.error();
  task_ = std::make_shared<const RenderTask>(std::move(*task));
  film_ = Film(spec.settings.width, spec.settings.height);
  compute_seconds_ += wall_seconds();
  return job_->move(JobState::rendering, [&](JobRecord& record) {
    record.plan = task_->plan;
    put_numbers(record);
  });
}

MapSource RunJob::map_source() {
  return [this](const MapKey& key, const Execution& execution) {
    return maps_.maps(*task_->scene, key, execution);
  };
}

Status RunJob::publish_preview() {
  const Clock::time_point begin = Clock::now();
  previewed_ = true;
  Result<Image> image = render_preview(*task_, map_source(), execution_);
  if (!image) return image.error();
  compute_seconds_ += std::chrono::duration<double>(Clock::now() - begin).count();
  job_->frames.publish(++revision_, std::move(*image), std::nullopt);
  told_ = wall_seconds();
  return job_->note(EventKind::frame, [&](JobRecord& record) {
    put_numbers(record);
    record.revision = revision_;
    record.first_frame_seconds = told_;
  });
}

Status RunJob::render_next_pass() {
  const Clock::time_point begin = Clock::now();
  const Result<PassImage> pass = render_pass(*task_, film_.pass_count(), map_source(), execution_);
  if (!pass) return pass.error();
  // After a cancel a pass may come back with holes: what was skipped is black.
  if (execution_.cancelled()) return cancelled();
  add_pass(film_, film_.pass_count(), *pass, execution_);
  ++passes_;
  if (is_measured(film_.pass_count())) error_ = estimate_error(film_, execution_);
  compute_seconds_ += std::chrono::duration<double>(Clock::now() - begin).count();
  return Done{};
}

bool RunJob::stop_rule_met() const { return rule_met(job_->spec().stop, progress()) != nullptr; }

Progress RunJob::progress() const { return {film_.pass_count(), compute_seconds_, error_}; }

Status RunJob::finish() {
  const auto numbers = [this](JobRecord& record) { put_numbers(record); };
  if (const Status moved = job_->move(JobState::finalizing, numbers); !moved) return moved;
  if (const Status published = publish(true); !published) return published;
  return job_->move(JobState::succeeded);
}

Status RunJob::publish(bool result) {
  ++revision_;
  error_ = estimate_error(film_, execution_);
  job_->frames.publish(revision_, film_picture(film_, execution_),
                       result ? std::optional(error_layers(film_, execution_)) : std::nullopt);
  told_ = wall_seconds();
  return job_->note(EventKind::frame, [&](JobRecord& record) {
    put_numbers(record);
    record.revision = revision_;
    if (!record.first_frame_seconds) record.first_frame_seconds = told_;
    record.series.push_back({revision_, record.passes, record.seconds, record.error});
  });
}

Status RunJob::tell_progress() {
  told_ = wall_seconds();
  return job_->note(EventKind::progress, [this](JobRecord& record) { put_numbers(record); });
}

void RunJob::put_numbers(JobRecord& record) const {
  record.passes = film_.pass_count();
  record.seconds = compute_seconds_;
  record.rejected = film_.rejected;
  if (error_.known) record.error = error_;
  record.map_hits = maps_.hits();
  record.map_disk_hits = maps_.disk_hits();
  record.map_misses = maps_.misses();
  record.eta_seconds = remaining_seconds(record.spec.stop, progress());
  // Other jobs take turns: what is left stretches as what is done has been stretched.
  if (record.eta_seconds && compute_seconds_ > 0)
    *record.eta_seconds *= std::max(1.0, wall_seconds() / compute_seconds_);
}

double RunJob::wall_seconds() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }

}  // namespace photond
