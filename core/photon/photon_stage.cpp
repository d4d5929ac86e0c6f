#include "core/photon/photon_stage.h"

#include "core/trace/accel.h"

namespace photond {

extern const char* const kPhotonSources;   // written by photon_sources.cmake

const Digest& photon_stage() {
  static const Digest stage = [] {
    Hasher hasher;
    hasher.update(kPhotonSources);
    hasher.update(embree_target());
    return hasher.finish();
  }();
  return stage;
}

}  // namespace photond
