#pragma once

#include "core/render/render.h"
#include "server/cli/commands.h"
#include "server/cli/progress.h"

namespace photond {

/// Wall-clock seconds of the stages before the first pass.
struct LoadSeconds {
  double load = 0;
  double prepare = 0;
  double plan = 0;
};

/// Refuses settings out of range, naming the option. Prints the error and returns the exit code.
int check_settings(const TaskOptions& options, const StopRule& stop);

/// Reads the scene and makes the render task. Errors: those of the files and of make_render_task.
Result<RenderTask> load_task(const TaskOptions& options, const Execution& execution, ProgressBar& bar,
                             LoadSeconds& seconds);

}  // namespace photond
