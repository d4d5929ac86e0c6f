#pragma once

#include <cstdint>
#include <optional>

#include "core/film/error.h"
#include "core/render/settings.h"

namespace photond {

/// How far a rendering is.
struct Progress {
  std::uint32_t passes = 0;
  double seconds = 0;  ///< of its own computing
  ErrorEstimate error;
};

/// Whether the error is to be measured after so many passes: after every one at first and then at every 1/8 of an
/// octave. A fixed set, so that where a rendering stops by its error does not depend on the clock; and cheap for fast
/// passes.
bool is_measured(std::uint32_t passes);

/// Whether the spread of so many passes says enough to stop by the error.
bool is_estimated(std::uint32_t passes);

/// The member of StopRule that ends the rendering now ("passes", "seconds", "relative_error"), or null.
const char* rule_met(const StopRule& stop, const Progress& progress);

/// Expected seconds of computing until `stop` holds, from what is done so far; nothing where unknown.
std::optional<double> remaining_seconds(const StopRule& stop, const Progress& progress);

}  // namespace photond
