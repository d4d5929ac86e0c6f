#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "server/jobs/stop_rule.h"

namespace photond {

/// One line such as `[#####-----]  51 %  pass 33  12.4 s  error 0.0312  ETA 12 s`, at most `columns` long.
std::string progress_line(const StopRule& stop, const Progress& progress, int columns);

/// "3.2 s", "4:07 min", "2:05 h".
std::string duration_text(double seconds);

/// ", estimated relative error 0.031 (noise 0.03, bias 0.01)"; empty while it is not known. `biased`: the method has a
/// bias beyond the estimate, which the text says.
std::string error_text(const ErrorEstimate& error, bool biased);

/// ", 12 samples rejected (…)" and what else of the film's samples is not as it should be; empty where nothing is.
std::string losses_text(const Film& film);

/// "preparing …", cut to `columns`.
std::string stage_line(const std::string& stage, int columns);

/// Repaints a line on stderr while something long runs. Silent where stderr is no terminal.
class ProgressBar {
 public:
  ProgressBar();
  ~ProgressBar();  ///< erases the line
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Shows a stage that has no measure: "loading", "preparing".
  void stage(const std::string& name);
  /// Shows the rendering; between two calls the seconds go on by themselves.
  void update(const StopRule& stop, const Progress& progress);

 private:
  void run(const std::stop_token& stop);
  std::string line() const;

  const bool terminal_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::string stage_;
  StopRule stop_;
  std::optional<Progress> progress_;
  double updated_ = 0;   // seconds of the steady clock at the last update
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace photond
