// How a run ends, or rests: what state and failures ask for, what is written down, what is given back.
#include <exception>
#include <utility>

#include "server/jobs/run_job.h"
#include "server/log.h"
#include "server/store/file.h"

namespace photond {

namespace {

/// Why a job waits that failed so; none: it has failed for good.
PauseReason pause_reason(const Error& error) {
  if (is_disk_full(error)) return PauseReason::disk_full;
  return is_disk_unreachable(error) ? PauseReason::disk_unreachable : PauseReason::none;
}

}  // namespace

void RunJob::take_failure_of(const std::function<Status()>& work) {
  try {
    if (const Status status = work(); !status) take_failure(status.error());
  } catch (const std::exception& failure) {  // out of memory, most likely
    take_failure({ErrorCode::internal, std::string("rendering failed: ") + failure.what(), ""});
  }
}

void RunJob::take_failure(const Error& error) {
  if (execution_.cancelled()) return;  // the job's state, or the end of the service, says what is to be done
  const JobState state = job_->state();
  if (is_terminal(state) || state == JobState::paused || state == JobState::canceling) return;
  const PauseReason reason = pause_reason(error);
  if (reason != PauseReason::none) {
    LogLine(LogLevel::warning, "job_waits").with("job", job_->id).with("why", error.message);
    return stall(job_->move(JobState::paused, [reason](JobRecord& record) { record.pause_reason = reason; }));
  }
  stall(job_->move(JobState::failed, [&](JobRecord& record) {
    if (task_) put_numbers(record);
    record.failure = error;
  }));
}

/// What the state that others, or a failure, have brought about asks for.
void RunJob::settle() {
  if (job_->state() == JobState::canceling) {
    stall(job_->move(JobState::canceled, [this](JobRecord& record) {
      if (task_) put_numbers(record);
    }));
  }
  bool draining = false;
  {
    const std::lock_guard lock(mutex_);
    draining = draining_;
  }
  const JobState state = job_->state();
  settled_ = unsaved_ = draining || state == JobState::paused;
  if (is_terminal(state)) return release();
  if (!settled_) return;
  const bool kept = put_away();
  if (draining && is_running(state)) stall(job_->move(JobState::queued, [this](JobRecord& record) {
    if (task_) put_numbers(record);
  }));
  if (kept) let_go();
}

/// Writes down what a job needs to go on, and its picture; false where that fails, as on a full disk: then memory keeps it.
bool RunJob::put_away() {
  if (!task_) return true;
  if (checkpoint_passes_ < film_.pass_count() && !checkpoint()) return false;
  if (job_->state() != JobState::paused) return true;
  if (published_passes_ < film_.pass_count() && !publish(false)) return false;
  return keep_picture(cancel_.get_token()).ok();
}

void RunJob::let_go() {
  film_ = Film();
  maps_.release();
  task_.reset();
  unsaved_ = false;
  missing_bytes_ = 0;
}

void RunJob::release() {
  let_go();
  const JobState state = job_->state();
  // Nothing hangs on these: what cannot be kept or dropped now is missing after a restart, or in the way.
  if (state != JobState::succeeded) (void)keep_seen_picture().ok();
  const std::size_t keep = state == JobState::canceled ? 0 : 1;
  (void)parts_.files.drop_checkpoints(job_->id, keep).ok();
}

/// After a change that the store refused there is nothing to do but to wait for the store.
void RunJob::stall(const Status& refused) {
  if (refused || refused.error().code == ErrorCode::conflict) return;  // a conflict: the job has moved meanwhile
  const std::lock_guard lock(mutex_);
  stalled_ = true;
}

/// Writes the newest picture to the disk in every format, where it survives the process; encoded here and now, so that
/// a revision's bytes never change.
Status RunJob::keep_picture(const std::stop_token& stop) {
  const std::uint32_t revision = job_->record().revision;
  for (int i = 0; i < kFrameFormats; ++i) {
    const auto format = static_cast<FrameFormat>(i);
    const Result<Frames::Bytes> bytes = job_->frames.get(revision, format, FrameLayer::radiance, stop);
    if (!bytes && bytes.error().code == ErrorCode::not_found) return Done{};  // none yet, or on the disk already
    if (!bytes) return bytes.error();
    const Status kept = parts_.files.put_frame(job_->id, revision, format, **bytes);
    if (!kept) return kept;
  }
  job_->frames.clear();
  return Done{};
}

/// Of a job that ended before its time, where somebody has asked for pictures: what was made of its newest, and what makes
/// the rest of it if they ask again. Nothing is compressed: whoever cancels wants the processor for something else.
Status RunJob::keep_seen_picture() {
  const std::uint32_t revision = job_->record().revision;
  if (job_->frames.asked()) {
    const Result<Frames::Bytes> exr = job_->frames.quick_exr(revision);
    if (!exr && exr.error().code == ErrorCode::not_found) return Done{};  // none yet, or on the disk already
    if (!exr) return exr.error();
    if (const Status kept = parts_.files.put_frame(job_->id, revision, FrameFormat::exr, **exr); !kept) return kept;
    for (const FrameFormat format : {FrameFormat::png, FrameFormat::jpg}) {
      const Frames::Bytes bytes = job_->frames.close(revision, format);
      if (!bytes) continue;
      if (const Status kept = parts_.files.put_frame(job_->id, revision, format, *bytes); !kept) return kept;
    }
  }
  job_->frames.clear();
  return Done{};
}

}  // namespace photond
