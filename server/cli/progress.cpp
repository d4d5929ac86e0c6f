#include "server/cli/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "server/cli/stopwatch.h"

namespace photond {
namespace {

std::string format(const char* pattern, double value) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

/// [0, 1]: the part of the expected time that is over.
double fraction_done(const StopRule& stop, const Progress& progress) {
  const auto left = remaining_seconds(stop, progress);
  if (!left) return 0;
  const double total = progress.seconds + *left;
  return total > 0 ? std::clamp(progress.seconds / total, 0.0, 1.0) : 1;
}

int terminal_columns() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

void print(const std::string& text) {
  std::fputs(text.c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace

std::string progress_line(const StopRule& stop, const Progress& progress, int columns) {
  std::string facts = format("%3.0f %%", std::floor(100 * fraction_done(stop, progress))) + "  pass " +
                      std::to_string(progress.passes) + "  " + duration_text(progress.seconds);
  if (progress.error.known) facts += format("  error %.4f", progress.error.relative);
  if (const auto left = remaining_seconds(stop, progress)) facts += "  ETA " + duration_text(*left);
  const int width = std::min(30, columns - static_cast<int>(facts.size()) - 4);
  if (width < 5) return facts.substr(0, static_cast<std::size_t>(std::max(0, columns)));
  const auto filled = static_cast<std::size_t>(fraction_done(stop, progress) * width);
  return "[" + std::string(filled, '#') + std::string(static_cast<std::size_t>(width) - filled, '-') + "]  " +
         facts;
}

std::string stage_line(const std::string& stage, int columns) {
  std::string line;
  for (const char c : stage) {
    const bool begins = (static_cast<unsigned char>(c) & 0xc0) != 0x80;   // a character of UTF-8
    if (begins && columns-- <= 2) break;
    line += c;
  }
  return line + " …";
}

std::string duration_text(double seconds) {
  if (seconds < 99.95) return format("%.1f s", seconds);
  const auto whole = static_cast<long long>(std::llround(seconds));
  const bool hours = whole >= 3600;
  const long long minor = hours ? whole / 60 % 60 : whole % 60;
  return std::to_string(whole / (hours ? 3600 : 60)) + (minor < 10 ? ":0" : ":") + std::to_string(minor) +
         (hours ? " h" : " min");
}

std::string error_text(const ErrorEstimate& error, bool biased) {
  const std::string label = biased ? ", biased method" : "";
  if (!error.known) return label;
  std::string text = ", estimated relative error " + format("%.4g", error.relative);
  if (error.bias > 0) text += format(" (noise %.4g", error.noise) + format(", bias %.4g)", error.bias);
  return text + (biased ? " without the bias of the method" : "");
}

std::string losses_text(const Film& film) {
  std::string text;
  if (film.rejected > 0) {
    text += ", " + std::to_string(film.rejected) + " samples rejected (not finite or too bright: they count as black)";
  }
  if (film.truncated > 0) text += ", " + std::to_string(film.truncated) + " paths cut at the depth limit";
  return text;
}

ProgressBar::ProgressBar() : terminal_(isatty(STDERR_FILENO) == 1) {
  if (terminal_) thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

ProgressBar::~ProgressBar() {
  if (!terminal_) return;
  thread_.request_stop();
  thread_.join();
  print("\r\033[K");
}

void ProgressBar::stage(const std::string& name) {
  const std::lock_guard lock(mutex_);
  stage_ = name;
  progress_.reset();
  changed_.notify_one();
}

void ProgressBar::update(const StopRule& stop, const Progress& progress) {
  const std::lock_guard lock(mutex_);
  stop_ = stop;
  progress_ = progress;
  updated_ = steady_seconds();
}

void ProgressBar::run(const std::stop_token& stop) {
  using namespace std::chrono_literals;
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    if (progress_ || !stage_.empty()) print("\r" + line() + "\033[K");
    changed_.wait_for(lock, stop, 200ms, [] { return false; });
  }
}

std::string ProgressBar::line() const {
  if (!progress_) return stage_line(stage_, terminal_columns() - 1);
  Progress now = *progress_;
  now.seconds += steady_seconds() - updated_;
  return progress_line(stop_, now, terminal_columns() - 1);
}

}  // namespace photond
