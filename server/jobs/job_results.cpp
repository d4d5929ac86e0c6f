// What jobs give: pictures, and checkpoints to go on from.
#include "server/jobs/jobs.h"

namespace photond {

namespace {

Error no_job(const std::string& id) { return {ErrorCode::not_found, "there is no job " + id, ""}; }

}  // namespace

Result<Jobs::CheckpointFile> Jobs::checkpoint(const std::string& id) const {
  const auto job = store_.job(id);
  if (!job) return no_job(id);
  const auto checkpoints = files_.checkpoints(id);
  if (!checkpoints) return checkpoints.error();
  const bool done = job->state == JobState::succeeded;
  for (const JobFiles::Checkpoint& checkpoint : *checkpoints) {
    if (done && checkpoint.passes != job->passes) continue;
    Result<FileBytes> bytes = files_.open(checkpoint);
    if (bytes) return CheckpointFile{checkpoint, std::move(*bytes)};
    if (bytes.error().code != ErrorCode::not_found) return bytes.error();  // else damaged, or replaced just now
  }
  const std::string what = done ? "all passes of job " : "job ";
  return Error{ErrorCode::not_found, "there is no checkpoint of " + what + id, ""};
}

Result<Frames::Bytes> Jobs::frame(const std::string& id, std::uint32_t revision, FrameFormat format,
                                  FrameLayer layer) const {
  const std::shared_ptr<RunJob> run = find(id);
  if (!run) return no_job(id);
  Result<Frames::Bytes> running = run->job()->frames.get(revision, format, layer);
  if (running || running.error().code != ErrorCode::not_found) return running;
  if (layer == FrameLayer::radiance) {
    Result<Blob> kept = files_.frame(id, revision, format);
    if (kept || kept.error().code != ErrorCode::not_found) return kept;
  }
  const Result<Blob> exr = files_.frame(id, revision, FrameFormat::exr);
  if (!exr) return running;
  Result<Frames::Bytes> picture = picture_from_exr(**exr, layer, format);
  if (picture || picture.error().code != ErrorCode::not_found) return picture;
  return Error{ErrorCode::not_found, "revision " + std::to_string(revision) + " was kept without its error", ""};
}

Result<FileBytes> Jobs::frame_file(const std::string& id, std::uint32_t revision, FrameFormat format) const {
  return files_.open_frame(id, revision, format);
}

}  // namespace photond
