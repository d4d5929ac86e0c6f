#pragma once

#include <vector>

#include "core/base/parallel.h"
#include "core/trace/accel.h"
#include "core/trace/enclosing.h"
#include "core/trace/lights.h"

namespace photond {

/// The volumes in which paths leave the lights. Light from infinity is in none.
struct LightMedia {
  std::vector<Medium> around;   ///< each light; empty where no volume is followed
  std::vector<bool> divided;    ///< emissive triangles that reach from one volume into another

  /// Of a path that starts at `start`.
  Medium at(const Scene& scene, const Accel& accel, std::uint32_t light, const Vec3& start) const {
    if (around.empty()) return {};
    return divided[light] ? enclosing(scene, accel, start) : around[light];
  }
  std::uint64_t memory_bytes() const { return around.capacity() * sizeof(Medium) + divided.capacity() / 8; }
};

/// Looks for them where any volume is followed.
LightMedia find_light_media(const Scene& scene, const Accel& accel, const Lights& lights, const Execution& execution);

}  // namespace photond
