#include "server/jobs/stop_rule.h"

#include <algorithm>
#include <bit>

namespace photond {
namespace {

constexpr std::uint32_t kPassesForEstimate = 8;

}  // namespace

bool is_measured(std::uint32_t passes) { return passes % std::max(1u, std::bit_floor(passes) / 8) == 0; }

bool is_estimated(std::uint32_t passes) { return passes >= kPassesForEstimate; }

const char* rule_met(const StopRule& stop, const Progress& progress) {
  if (stop.passes && progress.passes >= *stop.passes) return "passes";
  if (stop.seconds && progress.seconds >= *stop.seconds) return "seconds";
  const bool estimated = progress.error.known && is_estimated(progress.passes) && is_measured(progress.passes);
  if (stop.relative_error && estimated && progress.error.relative <= *stop.relative_error)
    return "relative_error";
  return nullptr;
}

std::optional<double> remaining_seconds(const StopRule& stop, const Progress& progress) {
  std::optional<double> left;
  const auto limit = [&left](double seconds) {
    left = std::max(0.0, left ? std::min(*left, seconds) : seconds);
  };
  const double seconds = progress.seconds;
  if (stop.seconds) limit(*stop.seconds - seconds);
  if (stop.passes && progress.passes > 0) {
    limit((static_cast<double>(*stop.passes) - progress.passes) * seconds / progress.passes);
  }
  if (stop.relative_error && progress.error.known && is_estimated(progress.passes)) {
    const double ratio = progress.error.relative / *stop.relative_error;
    limit(seconds * (ratio * ratio - 1));  // the error falls with 1/√passes
  }
  return left;
}

}  // namespace photond
