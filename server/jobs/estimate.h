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

/// What a job may take.
struct JobBudget {
  std::uint64_t memory_bytes = UINT64_MAX;  ///< as check_memory
  std::uint64_t kept_map_bytes = 0;         ///< of its photon maps, in the cache
};

/// Renders at least two passes and up to some seconds of them, of at most kPilotPixels; nothing where the job would
/// take more memory than it may. Errors: those of make_render_task, check_memory and render_pass.
Result<JobEstimate> estimate_job(std::shared_ptr<const PreparedScene> scene, const Camera& camera, const JobSpec& spec,
                                 const JobBudget& budget, const Execution& execution);

}  // namespace photond
