#pragma once

#include <optional>
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

/// A rendering after a pass whose error was measured.
struct MeasuredPass {
  Progress progress;
  std::optional<double> rel_mse;  ///< the true one, where there is a reference
};

/// A rendering that has ended.
struct Rendering {
  Film film;
  std::string stopped_by;  ///< member of StopRule, or "interrupt"
  double seconds = 0;      ///< maps included, comparisons with the reference not
  MapStatistics maps;
  std::vector<MeasuredPass> series;  ///< the last pass is always measured
};

/// Renders passes `first`, first + 1, … until the rule is met or the execution's stop token is triggered, which
/// abandons the pass that runs. `reference` may be null, else of the film's size. Errors: those of render_pass
/// except cancelled.
Result<Rendering> render_passes(const RenderTask& task, std::uint32_t first, const StopRule& stop,
                                const Image* reference, const Execution& execution, ProgressBar& bar);

}  // namespace photond
