#pragma once

#include <string>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/result.h"
#include "core/render/settings.h"
#include "core/trace/prepare.h"

namespace photond {

/// One decision of a plan.
struct PlanItem {
  std::string feature;       ///< "method", "caustic_map", "radius", "volume_absorption", …
  bool active = false;
  std::string reason;        ///< one sentence
};

/// What a scene needs and why; shown by `photond info`, in reports and in a job's JSON.
struct Plan {
  Method method = Method::path;   ///< never automatic
  bool biased = false;            ///< the method does not converge to the right picture (photon_map)
  bool uses_maps = false;
  float radius = 0;               ///< widest gather radius of the first pass in metres, as asked; 0: chosen for each gather
  std::vector<PlanItem> items;
};

/// Decides method and features. `settings.method` other than automatic is kept. Errors: cancelled; invalid_input where the
/// radius does not suit the scene's size ("/radius").
Result<Plan> make_plan(const PreparedScene& scene, const RenderSettings& settings, const Execution& execution);

}  // namespace photond
