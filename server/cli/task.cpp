#include <iostream>
#include <memory>

#include "server/api/task_identity.h"
#include "server/cli/cli.h"
#include "server/cli/commands.h"
#include "server/cli/files.h"
#include "server/cli/interrupt.h"
#include "server/cli/load_task.h"
#include "server/cli/passes.h"
#include "server/store/accumulator.h"

namespace photond {

int run_task(const TaskCommand& command) {
  const PassRange passes = command.passes;
  StopRule stop;
  stop.passes = passes.last - passes.first;
  if (const int code = check_settings(command.task, stop); code != kExitOk) return code;
  const Interrupt interrupt;
  const Status fine = check_outputs({command.output}, {command.task.scene, command.task.environment.file});
  if (const int code = print_refusal(fine); code != kExitOk) return code;
  const Workers workers(command.task.threads);
  lower_priority();
  const Execution execution = workers.execution(interrupt.token());
  LoadSeconds seconds;
  auto bar = std::make_unique<ProgressBar>();
  const auto task = load_task(command.task, execution, *bar, seconds);
  auto rendering = task ? render_passes(*task, passes.first, stop, nullptr, execution, *bar) : task.error();
  bar.reset();  // the line is erased before anything else is printed
  if (interrupt.signal() != 0) {
    std::cerr << "photond: interrupted before all passes were done: nothing is written\n";
    return 128 + interrupt.signal();
  }
  if (!rendering) return print_failure(command.task.scene, rendering.error());
  const auto identity = task_identity(*task);
  if (!identity) return print_failure("the program's own file", identity.error());
  const auto written = write_file(command.output, accumulator_bytes({to_text(*identity), std::move(rendering->film)}));
  if (!written) return print_failure(command.output, written.error());
  std::cerr << std::string(method_name(task->plan.method)) + ": passes " + std::to_string(passes.first) + ":" +
                   std::to_string(passes.last) + " in " + duration_text(rendering->seconds) + " -> " +
                   command.output + "\n";
  return kExitOk;
}

}  // namespace photond
