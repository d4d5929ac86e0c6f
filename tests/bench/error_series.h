#pragma once

#include <vector>

#include "core/film/image.h"
#include "core/render/render.h"

namespace photond::bench {

/// A rendering as it stood after some time: the passes that were complete by then.
struct ErrorRecord {
  double seconds = 0;
  std::uint32_t passes = 0;
  double rel_mse = 0;                  ///< true, against the reference; its noise is contained
  double estimated = 0;                ///< the square of ErrorEstimate::relative; 0 while nothing is known
  double median_block_deviation = 0;   ///< Comparison's
};

/// The times √2 apart up to `seconds` at which a rendering is measured: …, 2.5, 2.5·√2, 5, …, and `seconds` itself.
std::vector<double> measured_times(double seconds);

/// Renders for the last of `times` (ascending) and measures the picture at each of them. Measuring does not count.
/// Times before the end of the first pass have no record. Errors: those of render_pass and compare_images.
Result<std::vector<ErrorRecord>> error_series(const RenderTask& task, const Image& reference,
                                              const std::vector<double>& times, const Execution& execution);

}  // namespace photond::bench
