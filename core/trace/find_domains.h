#pragma once

#include "core/base/parallel.h"
#include "core/trace/accel.h"
#include "core/trace/lights.h"
#include "core/trace/surface_boxes.h"

namespace photond {

/// What of the light that emissive triangles send out meets anything.
struct DomainFinding {
  bool emitters = false;     ///< there are such triangles
  bool active = false;       ///< paths are emitted only to where they may
  double meeting = 1;        ///< share of pilot paths
  double share = 1;          ///< of what could be emitted, that is; where `meeting` is small enough to look
  double effort = 1;         ///< paths, of all lights, that are as good as one that may leave whereto ever
};

/// Lets paths leave emissive triangles only from where and whereto they may meet a surface, where much of the light
/// goes past all of them. A pure function of the scene.
DomainFinding find_domains(const Scene& scene, const Bounds3& bounds, const Accel& accel, Lights& lights,
                           const Execution& execution);

/// Whereto one of `count` such triangles may shine on what the boxes hold: nothing is missing, and the more triangles,
/// the more is in it in vain. Divided by place where the triangle shines evenly.
EmissionDomain find_domain(const EmitterTriangle& emitter, bool double_sided, bool evenly, std::size_t count,
                           std::span<const SurfaceBox> boxes);

}  // namespace photond
