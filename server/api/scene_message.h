#pragma once

#include "server/api/json.h"
#include "server/jobs/scene_library.h"

namespace photond {

/// What a scene contains: counts, bounds, environment, cameras, lights, materials, warnings.
Json report_message(const SceneSummary& summary);

/// A scene as clients see it; with `summary` also its report and the plan for default settings.
Json scene_message(const SceneRecord& scene, const SceneSummary* summary);

}  // namespace photond
