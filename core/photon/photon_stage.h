#pragma once

#include "core/base/digest.h"

namespace photond {

/// Names all that the bits of photon maps depend on beside the scene and the key: the sources of what shoots and
/// indexes them, compiler and options, the Embree that runs, and what it uses of this CPU. Maps of another stage are
/// other maps.
const Digest& photon_stage();

}  // namespace photond
