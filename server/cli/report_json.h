#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "server/cli/commands.h"
#include "server/cli/passes.h"

namespace photond {

/// Wall-clock seconds of a rendering's stages.
struct StageSeconds {
  double load = 0;
  double prepare = 0;
  double plan = 0;
  double encode = 0;
};

nlohmann::json plan_json(const Plan& plan);

/// Counts, bounds, cameras, lights, materials and warnings.
nlohmann::json scene_json(const PreparedScene& prepared);

/// What `photond render --report` writes: scene, plan with reasons, settings, passes, seconds, maps, error and the
/// series of error against time.
nlohmann::json render_json(const RenderCommand& command, const StopRule& stop, const RenderTask& task,
                           const Rendering& rendering, const StageSeconds& seconds);

/// Pretty text of `json` with a final newline. Names in a file may not be valid UTF-8: what is not is replaced.
std::string json_text(const nlohmann::json& json);

}  // namespace photond
