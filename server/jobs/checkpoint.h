#pragma once

#include <optional>
#include <stop_token>
#include <string>

#include "core/film/film.h"
#include "server/store/job_files.h"

namespace photond {

/// Says when a running job's film is worth writing down: what a crash can cost is 5 % of the computing so far, at most
/// 15 s; but never less than twenty times what writing costs, so that writing takes at most a twentieth of the time.
class CheckpointRule {
 public:
  /// `seconds` of computing so far.
  bool due(double seconds) const;
  /// Whether a film that took `seconds` is worth keeping for later at all.
  bool worth_keeping(double seconds) const { return seconds >= kCostRatio * cost_seconds_; }
  /// A checkpoint was written or read at `seconds`, which cost `cost_seconds`.
  void done(double seconds, double cost_seconds);

 private:
  static constexpr double kMaxSeconds = 15;
  static constexpr double kShare = 0.05;
  static constexpr double kCostRatio = 20;

  double last_seconds_ = 0;
  double cost_seconds_ = 0.01;  // until it is known: a file and a commit, waited for
};

/// A film as it was, and the seconds of computing in it.
struct Restored {
  Film film;
  double seconds = 0;
};

/// Nothing is kept where `stop` asks meanwhile. Errors: cancelled, those of the disk.
Status save_checkpoint(JobFiles& files, const std::string& job, const std::string& identity, const Film& film,
                       double seconds, const std::stop_token& stop);

/// The newest checkpoint that is whole and of the same picture and program, which `identity` says; nothing where there
/// is none. What is damaged or of another program is removed: the job begins further back, and what it writes then must
/// not give way to that. Errors: io.
Result<std::optional<Restored>> restore_checkpoint(JobFiles& files, const std::string& job,
                                                   const std::string& identity);

}  // namespace photond
