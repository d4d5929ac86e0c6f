#pragma once

#include <cstdint>
#include <memory>

#include "core/base/parallel.h"
#include "core/base/result.h"
#include "core/render/plan.h"
#include "core/scene/camera.h"
#include "core/trace/prepare.h"
#include "server/store/records.h"

namespace photond {

/// What a job will cost, as far as a few passes of a small picture tell.
struct JobEstimate {
  Plan plan;
  std::uint32_t passes = 0;        ///< until its stop rule holds
  double seconds = 0;              ///< of its own computing, with photon maps that are not cached
  std::uint64_t memory_bytes = 0;  ///< at its peak: scene, film, picture, and the photon maps it leaves in the cache
};

/// `kept_map_bytes` is how much of its photon maps a job may leave in the cache. Renders at least two passes and up to some seconds of them, of at most kPilotPixels. Errors: those of make_render_task
/// and render_pass.
Result<JobEstimate> estimate_job(std::shared_ptr<const PreparedScene> scene, const Camera& camera, const JobSpec& spec,
                                 std::uint64_t kept_map_bytes, const Execution& execution);

}  // namespace photond
