#pragma once

#include <string>

#include "server/api/json.h"
#include "server/api/task_identity.h"
#include "server/cli/commands.h"
#include "server/cli/load_task.h"
#include "server/cli/passes.h"
#include "server/jobs/scene_library.h"

namespace photond {

/// What is said of a scene, with the plan for the task at hand.
SceneSummary summarize(const PreparedScene& prepared, const Plan& plan);

/// The digest and the contents of a scene file, and the plan with its reasons.
Json info_json(const std::string& file, const PreparedScene& prepared, const SceneSummary& summary);

/// Null where nothing is known yet.
Json error_json(const Film& film, const ErrorEstimate& error);

/// What `photond render --report` writes: scene, plan with reasons, settings, passes, seconds, maps, error and
/// the series of error against time.
Json render_json(const RenderCommand& command, const StopRule& stop, const RenderTask& task,
                 const Rendering& rendering, const LoadSeconds& seconds, double encode_seconds);

/// Indented text with a final newline. Names in a file may not be valid UTF-8: what is not is replaced.
std::string indented(const Json& json);

}  // namespace photond
