#pragma once

#include "core/base/parallel.h"
#include "core/trace/accel.h"
#include "core/trace/lights.h"

namespace photond {

/// What aiming at the casters of a scene is worth.
struct AimFinding {
  bool casters = false;      ///< there are surfaces to aim at
  bool reached = false;      ///< light goes by way of one of them to where photons are gathered
  bool active = false;       ///< some lights aim
  double ordinary = 0;       ///< share of the paths of such a light (of the best, where none is active) that do so
  double aimed = 0;          ///< the same of the paths that aim
  double share = 0;          ///< of its paths that aim
  double effort = 1;         ///< paths, of all lights, that leave as little noise as one where none aims
};

/// Lets lights aim at glass and polished metal where ordinary emission seldom reaches it: a fixed number of pilot
/// paths to each caster from each of the strongest lights tells how much light arrives by way of it. A pure function
/// of the scene.
AimFinding learn_aim(const Scene& scene, const Accel& accel, Lights& lights, const Execution& execution);

}  // namespace photond
