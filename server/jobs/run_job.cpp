#include "server/jobs/run_job.h"

#include <algorithm>
#include <utility>

#include "core/film/film_bytes.h"
#include "core/render/note.h"
#include "server/store/file.h"

namespace photond {

namespace {

constexpr double kProgressSeconds = 0.5;  // between two progress events
// A job that kills the service each time must not do so for ever. More than one: others may kill it in the job's turn.
constexpr std::uint32_t kMaxCrashes = 5;
// What a checkpoint leaves free, so that the job's pictures, in all formats, find room, too.
constexpr std::uint64_t kPictureBytesPerPixel = 64;

std::string note_of(const Plan& plan) { return picture_note(method_name(plan.method), plan.biased); }

}  // namespace

RunJob::RunJob(std::shared_ptr<Job> job, const RunParts& parts) : job_(std::move(job)), parts_(parts), maps_(parts.maps) {
  const JobRecord record = job_->record();
  earlier_hits_ = record.map_hits;
  earlier_disk_hits_ = record.map_disk_hits;
  earlier_misses_ = record.map_misses;
  least_error_ = record.least_error;
}

// --- what others may ask --------------------------------------------------------------------------------------------

bool RunJob::claim() {
  const std::lock_guard lock(mutex_);
  stalled_ = false;
  return !std::exchange(scheduled_, true);
}

void RunJob::interrupt() {
  const std::lock_guard lock(mutex_);
  stop_.request_stop();
}

void RunJob::cancel() {
  cancel_.request_stop();
  interrupt();
}

void RunJob::drain() {
  const std::lock_guard lock(mutex_);
  draining_ = true;
  stop_.request_stop();
}

bool RunJob::stalled() const {
  const std::lock_guard lock(mutex_);
  return stalled_;
}

Status RunJob::put_back() {
  const JobRecord record = job_->record();
  if (record.state == JobState::canceling) return job_->move(JobState::canceled);
  if (!is_running(record.state)) return Done{};
  const bool blamed = parts_.turn.last() == job_->id;
  if (blamed && record.crashes + 1 >= kMaxCrashes) {
    return job_->move(JobState::failed, [&](JobRecord& changed) {
      changed.failure = Error{ErrorCode::internal,
                              "the service ended " + std::to_string(record.crashes + 1) +
                                  " times in a row while this job was computed; retry it if the job is not the reason",
                              ""};
    });
  }
  return job_->move(JobState::queued, [blamed](JobRecord& changed) { changed.crashes += blamed ? 1 : 0; });
}

// --- slices -----------------------------------------------------------------------------------------------------------

bool RunJob::step() {
  arm();
  parts_.turn.give(job_->id);
  take_failure_of([this] { return advance(); });
  // Apart from that: a job that failed by what was thrown gives its memory back, too.
  take_failure_of([this] {
    settle();
    return Status(Done{});
  });
  parts_.turn.give({});
  return !rest();
}

/// A run that was interrupted and is wanted again gets a stop token of its own.
void RunJob::arm() {
  const JobState state = job_->state();
  const std::lock_guard lock(mutex_);
  const bool wanted = state == JobState::queued || is_running(state);
  if (wanted && !draining_ && stop_.stop_requested()) stop_ = std::stop_source();
  execution_ = parts_.workers.execution(stop_.get_token());
}

/// Whether the scheduler is to forget the run; together with `claim` nobody's wish to go on is lost in between. Nor is a
/// wish to rest that came after `settle`: the next slice puts the job away.
bool RunJob::rest() {
  const std::lock_guard lock(mutex_);
  const JobState state = job_->state();
  const bool rests = state == JobState::paused || draining_;
  const bool over = is_terminal(state) || stalled_ || (rests && settled_);
  if (over) scheduled_ = false;
  return over;
}

Status RunJob::advance() {
  const JobState state = job_->state();
  if (execution_.cancelled() || is_terminal(state) || state == JobState::paused || state == JobState::canceling) {
    return cancelled();
  }
  if (state != JobState::rendering || !task_) return prepare();
  const bool nothing_shown = film_.pass_count() == 0 && !previewed_ && job_->record().revision == 0;
  if (nothing_shown && has_preview(*task_)) return publish_preview();
  // Not before the preview: a film of many pixels takes as long.
  if (film_.complete.empty()) film_ = Film(task_->settings.width, task_->settings.height);
  // By what was restored. Without a pass there is no picture, though preparing may have taken all the time there was.
  if (film_.pass_count() > 0 && stop_rule_met()) return finish();
  if (const Status rendered = render_next_pass(); !rendered) return rendered;
  if (stop_rule_met()) return finish();
  if (is_recent(job_->looked_at()) && rule_.due(film_.pass_count(), wall_seconds())) {
    if (const Status published = publish(false); !published) return published;
  }
  if (!checkpoints_.due(compute_seconds_)) return wall_seconds() - told_ >= kProgressSeconds ? tell_progress() : Done{};
  // First the record: it knows the least error of all passes that are in a checkpoint.
  if (const Status told = tell_progress(); !told) return told;
  return dares_ ? checkpoint_if_there_is_room() : checkpoint();
}

Status RunJob::prepare() {
  if (const Status queued = put_back(); !queued) return queued;
  begin_ = Clock::now();
  told_ = 0;
  rule_ = RevisionRule();
  if (const Status moved = job_->move(JobState::preparing); !moved) return moved;
  if (!task_) {
    add_to_earlier();
    if (const Status made = make_task(); !made) return made;
    if (const Status restored = restore(); !restored) return restored;
    compute_seconds_ += wall_seconds();
  }
  return job_->move(JobState::rendering, [&](JobRecord& record) {
    record.plan = task_->plan;
    put_numbers(record);
  });
}

void RunJob::add_to_earlier() {
  earlier_hits_ += maps_.hits();
  earlier_disk_hits_ += maps_.disk_hits();
  earlier_misses_ += maps_.misses();
  maps_.count_anew();
}

Status RunJob::make_task() {
  const JobSpec& spec = job_->spec;
  const auto scene = parts_.scenes.prepared(spec.scene, spec.environment, execution_);
  if (!scene) return scene.error();
  const Result<Camera> camera = choose_camera((*scene)->scene.cameras, spec.camera);
  if (!camera) return camera.error();
  Result<RenderTask> task = make_render_task(*scene, *camera, spec.photons, spec.settings, execution_,
                                             [this](const auto&... of) { return maps_.guide(of...); });
  if (!task) return task.error();
  if (const Status fits = check_memory(memory_need(*task, spec.settings), parts_.max_memory_bytes); !fits) return fits;
  Result<std::string> identity = parts_.identity(*task);
  if (!identity) return identity.error();
  task_ = std::make_shared<const RenderTask>(std::move(*task));
  identity_ = std::move(*identity);
  return Done{};
}

Status RunJob::restore() {
  film_ = Film();
  error_ = {};
  measured_passes_ = 0;
  compute_seconds_ = 0;
  published_passes_ = 0;
  checkpoints_ = CheckpointRule();
  const Clock::time_point begin = Clock::now();
  Result<std::optional<Restored>> restored = restore_checkpoint(parts_.files, job_->id, identity_);
  if (!restored) return restored.error();
  if (*restored) {
    film_ = std::move((*restored)->film);
    compute_seconds_ = (*restored)->seconds;
    // The same value as when this pass was done: where the job stops does not depend on the restart.
    measure();
    checkpoints_.done(compute_seconds_, std::chrono::duration<double>(Clock::now() - begin).count());
  } else {
    earlier_hits_ = earlier_disk_hits_ = earlier_misses_ = 0;  // as the passes they were for
    least_error_.reset();
  }
  checkpoint_passes_ = film_.pass_count();
  return Done{};
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
  image->note = note_of(task_->plan);
  job_->frames.publish(1, std::move(*image), std::nullopt);
  told_ = wall_seconds();
  return job_->note(EventKind::frame, [&](JobRecord& record) {
    put_numbers(record);
    record.revision = 1;
    record.first_frame_seconds = told_;
  });
}

Status RunJob::render_next_pass() {
  const Clock::time_point begin = Clock::now();
  const Result<PassImage> pass = render_pass(*task_, film_.pass_count(), map_source(), execution_);
  if (!pass) return pass.error();
  // After an interrupt a pass may come back with holes: what was skipped is black.
  if (execution_.cancelled()) return cancelled();
  add_pass(film_, film_.pass_count(), *pass, execution_);
  ++parts_.passes;
  if (is_measured(film_.pass_count())) measure();
  compute_seconds_ += std::chrono::duration<double>(Clock::now() - begin).count();
  return Done{};
}

void RunJob::measure() {
  if (measured_passes_ == film_.pass_count()) return;
  const ErrorEstimate error = estimate_error(film_, until_cancelled());
  if (cancel_.stop_requested()) return;
  error_ = error;
  measured_passes_ = film_.pass_count();
  if (error_.known && is_estimated(measured_passes_) && is_measured(measured_passes_))
    least_error_ = std::min(error_.relative, least_error_.value_or(error_.relative));
}

bool RunJob::stop_rule_met() const { return rule_met(job_->stop_rule(), progress()) != nullptr; }

Progress RunJob::progress() const { return {film_.pass_count(), compute_seconds_, error_}; }

Status RunJob::finish() {
  const auto numbers = [this](JobRecord& record) { put_numbers(record); };
  if (const Status moved = job_->move(JobState::finalizing, numbers); !moved) return moved;
  if (const Status published = publish(true); !published) return published;
  if (const Status kept = keep_picture(execution_.stop); !kept) return kept;
  // For `extend`, which otherwise begins anew: the bits are the same. Where there is one already, it lacks passes.
  const bool worth_keeping = checkpoint_passes_ > 0 || checkpoints_.worth_keeping(compute_seconds_);
  if (checkpoint_passes_ < film_.pass_count() && worth_keeping) {
    if (const Status saved = checkpoint_if_there_is_room(); !saved) return saved;
  }
  return job_->move(JobState::succeeded);
}

Status RunJob::publish(bool result) {
  const std::uint32_t revision = job_->record().revision + 1;
  measure();
  Image picture = film_picture(film_, until_cancelled());
  picture.note = note_of(task_->plan);
  std::optional<ErrorLayers> layers;
  if (result || (error_.known && is_recent(job_->error_looked_at()))) layers = error_layers(film_, until_cancelled());
  if (cancel_.stop_requested()) return cancelled();
  job_->frames.publish(revision, std::move(picture), std::move(layers));
  told_ = wall_seconds();
  const Status told = job_->note(EventKind::frame, [&](JobRecord& record) {
    put_numbers(record);
    record.revision = revision;
    if (!record.first_frame_seconds) record.first_frame_seconds = told_;
    record.series.push_back({revision, record.passes, record.seconds, record.error});
  });
  if (told) published_passes_ = film_.pass_count();
  return told;
}

Status RunJob::checkpoint() {
  const Clock::time_point begin = Clock::now();
  missing_bytes_ = film_size(film_) + kPictureBytesPerPixel * film_.width * film_.height;
  if (const Status room = parts_.room.make_room(missing_bytes_, job_->id); !room) return room;
  const Status saved = save_checkpoint(parts_.files, job_->id, identity_, film_, compute_seconds_, cancel_.get_token());
  if (!saved) return saved;
  missing_bytes_ = 0;
  dares_ = false;
  checkpointed_ = true;
  checkpoint_passes_ = film_.pass_count();
  checkpoints_.done(compute_seconds_, std::chrono::duration<double>(Clock::now() - begin).count());
  return Done{};
}

Status RunJob::checkpoint_if_there_is_room() {
  const Clock::time_point begin = Clock::now();
  const Status saved = checkpoint();
  if (saved || !is_disk_full(saved.error())) return saved;
  checkpoints_.done(compute_seconds_, std::chrono::duration<double>(Clock::now() - begin).count());
  return Done{};
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
  record.least_error = least_error_;
  record.map_hits = earlier_hits_ + maps_.hits();
  record.map_disk_hits = earlier_disk_hits_ + maps_.disk_hits();
  record.map_misses = earlier_misses_ + maps_.misses();
  if (checkpointed_) record.crashes = 0;
  record.eta_seconds = remaining_seconds(record.spec.stop, progress());
  // Other jobs take turns: what is left stretches as what is done has been stretched.
  if (record.eta_seconds && compute_seconds_ > 0)
    *record.eta_seconds *= std::max(1.0, wall_seconds() / compute_seconds_);
}

double RunJob::wall_seconds() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }

}  // namespace photond
