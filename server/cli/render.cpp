#include <iostream>
#include <memory>

#include "core/film/compare.h"
#include "core/render/note.h"
#include "server/cli/cli.h"
#include "server/cli/commands.h"
#include "server/cli/files.h"
#include "server/cli/interrupt.h"
#include "server/cli/load_task.h"
#include "server/cli/passes.h"
#include "server/cli/picture.h"
#include "server/cli/printable.h"
#include "server/cli/report_json.h"
#include "server/cli/stopwatch.h"

namespace photond {
namespace {

StopRule stop_of(const RenderCommand& command) {
  const StopRule& stop = command.stop;
  return stop.passes || stop.seconds || stop.relative_error ? stop : kDefaultStop;
}

/// The picture to compare with, empty where none is asked for. Errors: those of the file, and where no picture of
/// these settings can be compared with it.
Result<Image> read_reference(const RenderCommand& command) {
  if (command.reference.empty()) return Image();
  auto reference = read_picture(command.reference);
  if (!reference) return reference;
  const Image black(command.task.settings.width, command.task.settings.height);
  if (const auto comparable = compare_images(black, *reference); !comparable) return comparable.error();
  return reference;
}

void print_warnings(const Scene& scene) {
  for (const std::string& warning : scene.warnings) std::cerr << "photond: warning: " + printable(warning) + "\n";
}

int write_results(const RenderCommand& command, const RenderTask& task, const Rendering& rendering,
                  const LoadSeconds& seconds) {
  const Stopwatch watch;
  const std::string note = picture_note(method_name(task.plan.method), task.plan.biased);
  for (const std::string& output : command.outputs) {
    if (const auto written = write_picture(output, rendering.film, note); !written)
      return print_failure(output, written.error());
  }
  const double encode_seconds = watch.seconds();
  if (command.report.empty()) return kExitOk;
  const std::string text =
      indented(render_json(command, stop_of(command), task, rendering, seconds, encode_seconds));
  const auto written = write_file(command.report, std::as_bytes(std::span(text)));
  return written ? kExitOk : print_failure(command.report, written.error());
}

void print_summary(const RenderCommand& command, const RenderTask& task, const Rendering& rendering) {
  const std::uint32_t passes = rendering.film.pass_count();
  const MeasuredPass& last = rendering.series.back();
  std::string text = std::string(method_name(task.plan.method)) + ": " + std::to_string(passes) +
                     (passes == 1 ? " pass in " : " passes in ") + duration_text(rendering.seconds) +
                     error_text(last.progress.error, task.plan.biased) + losses_text(rendering.film);
  if (last.rel_mse) text += ", true relMSE " + std::to_string(*last.rel_mse);
  text += " ->";
  for (const std::string& output : command.outputs) text += " " + output;
  std::cerr << text + "\n";
}

}  // namespace

int run_render(const RenderCommand& command) {
  if (const int code = check_settings(command.task, stop_of(command)); code != kExitOk) return code;
  const Interrupt interrupt;
  const auto interrupted = [&] {
    std::cerr << "photond: interrupted before the first pass was done: nothing is written\n";
    return 128 + interrupt.signal();
  };
  const int refused = check_pictures(command.outputs, command.report,
                                     {command.task.scene, command.task.environment.file, command.reference});
  if (refused != kExitOk) return refused;
  const auto reference = read_reference(command);
  if (!reference) return print_failure(command.reference, reference.error());
  const Workers workers(command.task.threads);
  lower_priority();
  const Execution execution = workers.execution(interrupt.token());

  LoadSeconds seconds;
  auto bar = std::make_unique<ProgressBar>();
  const auto task = load_task(command.task, execution, *bar, seconds);
  if (!task) {
    bar.reset();
    return interrupt.signal() != 0 ? interrupted() : print_failure(command.task.scene, task.error());
  }
  const Image* const compared = reference->pixels.empty() ? nullptr : &*reference;
  const auto rendering = render_passes(*task, 0, stop_of(command), compared, execution, *bar);
  bar.reset();  // the line is erased before anything else is printed
  if (!rendering) return print_failure(command.task.scene, rendering.error());
  if (rendering->film.pass_count() == 0) return interrupted();
  if (const int code = write_results(command, *task, *rendering, seconds); code != kExitOk) return code;
  print_warnings(task->scene->scene);
  print_summary(command, *task, *rendering);
  return interrupt.signal() != 0 ? 128 + interrupt.signal() : kExitOk;
}

}  // namespace photond
