#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/result.h"
#include "core/film/image.h"
#include "core/photon/guide.h"
#include "core/photon/photon_maps.h"
#include "core/render/plan.h"
#include "core/render/settings.h"
#include "core/scene/camera.h"
#include "core/trace/prepare.h"

namespace photond {

/// Everything that determines a picture. Immutable while it renders; shared with whoever reports on it.
struct RenderTask {
  std::shared_ptr<const PreparedScene> scene;
  Camera camera;             ///< relative to Scene::origin
  PhotonSettings photons;
  RenderSettings settings;
  Plan plan;                 ///< of make_plan(*scene, settings)
  std::shared_ptr<const GatherGuide> guide;   ///< null where no photons are gathered
  Medium start;              ///< the volumes around the camera
};

/// Checks the settings and makes the plan. `camera` stands in the file's coordinates. Where photons are gathered it asks
/// `guides` for a guide, which may take some milliseconds to a second. Errors: bad settings, cancelled, those of `guides`.
Result<RenderTask> make_render_task(std::shared_ptr<const PreparedScene> scene, const Camera& camera,
                                    const PhotonSettings& photons, const RenderSettings& settings,
                                    const Execution& execution,
                                    const GuideSource& guides = build_gather_guide);

/// The photon maps that a pass of the method gathers from; `photon_map`: the same in all passes.
MapKey map_key(const Digest& scene, const PhotonSettings& photons, Method method, std::uint32_t pass);

/// Renders pass `pass` (0, 1, …) of the task: an estimate of the picture independent of all other passes
/// (`photon_map`: sharing one map). A pure function of (task, pass). Asks `maps` for photon maps at most once.
Result<PassImage> render_pass(const RenderTask& task, std::uint32_t pass, const MapSource& maps,
                              const Execution& execution);

}  // namespace photond
