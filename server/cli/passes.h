#pragma once

#include <string>
#include <vector>

#include "core/film/film.h"
#include "core/film/reconstruct.h"
#include "core/render/render.h"
#include "server/cli/progress.h"

namespace photond {

/// What was built for a rendering's photon maps, summed over the passes.
struct MapStatistics {
  std::uint64_t built = 0;
  std::uint64_t emitted = 0;         ///< paths
  std::uint64_t global_photons = 0;  ///< stored
  std::uint64_t caustic_photons = 0;
  std::uint64_t rays = 0;
  std::uint64_t largest_bytes = 0;
  double seconds = 0;
  EnergyLedger ledger;  ///< W, mean over the maps
};

/// A rendering that has ended.
struct Rendering {
  Film film;
  std::string stopped_by;  ///< member of StopRule, or "interrupt"
  double seconds = 0;      ///< maps included
  MapStatistics maps;
  std::vector<Progress> series;  ///< after each pass whose error was measured
};

/// Renders passes 0, 1, … until the rule is met or the execution's stop token is triggered, which abandons the
/// pass that runs. Errors: those of render_pass except cancelled.
Result<Rendering> render_passes(const RenderTask& task, const StopRule& stop, const Execution& execution,
                                ProgressBar& bar);

}  // namespace photond
