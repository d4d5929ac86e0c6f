#include "server/jobs/checkpoint.h"

#include <algorithm>

#include "server/store/accumulator.h"

namespace photond {

namespace {

/// Nothing where it is damaged or of another picture or program.
Result<std::optional<Film>> read_film_of(JobFiles& files, const JobFiles::Checkpoint& checkpoint,
                                         const std::string& identity) {
  const Result<Blob> bytes = files.read(checkpoint);
  if (!bytes && bytes.error().code != ErrorCode::not_found) return bytes.error();
  if (!bytes) return std::optional<Film>();
  Result<Accumulator> accumulator = read_accumulator(**bytes);
  if (!accumulator || accumulator->identity != identity) return std::optional<Film>();
  const std::vector<PassRange>& passes = accumulator->film.passes;
  if (passes.size() != 1 || passes[0].first != 0) return std::optional<Film>();  // a job goes on where its passes end
  return std::optional(std::move(accumulator->film));
}

}  // namespace

bool CheckpointRule::due(double seconds) const {
  const double interval = std::max(std::min(kMaxSeconds, kShare * seconds), kCostRatio * cost_seconds_);
  return seconds - last_seconds_ >= interval;
}

void CheckpointRule::done(double seconds, double cost_seconds) {
  last_seconds_ = seconds;
  cost_seconds_ = cost_seconds;
}

Status save_checkpoint(JobFiles& files, const std::string& job, const std::string& identity, const Film& film,
                       double seconds, const std::stop_token& stop) {
  return files.put_checkpoint(job, film.pass_count(), seconds, [&](const Blobs::Sink& sink) {
    return write_accumulator(identity, film, [&](std::span<const std::byte> piece) -> Status {
      return stop.stop_requested() ? cancelled() : sink(piece);
    });
  });
}

Result<std::optional<Restored>> restore_checkpoint(JobFiles& files, const std::string& job,
                                                   const std::string& identity) {
  const auto checkpoints = files.checkpoints(job);
  if (!checkpoints) return checkpoints.error();
  for (const JobFiles::Checkpoint& checkpoint : *checkpoints) {
    Result<std::optional<Film>> film = read_film_of(files, checkpoint, identity);
    if (!film) return film.error();
    if (*film) return std::optional(Restored{std::move(**film), checkpoint.seconds});
    if (const Status dropped = files.drop_checkpoint(job, checkpoint); !dropped) return dropped.error();
  }
  return std::optional<Restored>();
}

}  // namespace photond
