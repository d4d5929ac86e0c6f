#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>

#include "core/base/parallel.h"
#include "core/base/result.h"
#include "core/scene/scene.h"
#include "core/trace/accel.h"
#include "core/trace/find_domains.h"
#include "core/trace/learn_aim.h"
#include "core/trace/light_media.h"
#include "core/trace/lights.h"
#include "core/trace/placed_mesh.h"

namespace photond {

/// A scene with what is derived from it once and never changes: digest, intersection accelerator, light
/// distribution. Self-contained; shared between jobs.
struct PreparedScene {
  Scene scene;
  Digest digest;
  Bounds3 bounds;
  Accel accel;
  Lights lights;
  DomainFinding domain;              ///< whereto emissive triangles send paths, and why
  AimFinding aim;                    ///< what the lights aim at, and why
  /// Where paths are directed, each is worth more: so many are traced of those that would leave lights in all directions.
  double directed_share = 1;
  LightMedia light_media;            ///< the volumes around each light
  bool shares_gloss = false;         ///< whether photons that come by way of a caster are stored on gloss
  std::vector<PlacedMesh> placed;    ///< for each instance, and none
  std::size_t touching_glass = 0;    ///< placed triangles of glass that were held apart from others (separate_touching)
  std::uint64_t triangle_count = 0;  ///< placed triangles: instances counted each
  std::uint64_t memory_bytes = 0;    ///< estimate: scene, textures, accelerator and lights

  /// What a ray has met, or the one more that stands for nothing.
  const PlacedMesh& placed_at(const Hit& hit) const {
    return placed[std::min<std::size_t>(hit.instance, placed.size() - 1)];
  }
};

/// Builds the accelerator and the lights. Errors: cancelled, or the accelerator's own (out of memory).
Result<std::shared_ptr<const PreparedScene>> prepare(Scene scene, const Execution& execution);

}  // namespace photond
