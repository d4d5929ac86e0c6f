#include <iostream>
#include <utility>

#include "server/cli/cli.h"
#include "server/cli/commands.h"
#include "server/cli/files.h"
#include "server/cli/interrupt.h"
#include "server/cli/load_scene.h"
#include "server/cli/passes.h"
#include "server/cli/picture.h"
#include "server/cli/report_json.h"
#include "server/cli/stopwatch.h"

namespace photond {
namespace {

int print_usage_error(const std::string& message) {
  std::cerr << "photond: " + message + "\n";
  return kExitUsage;
}

StopRule stop_of(const RenderCommand& command) {
  const StopRule& stop = command.stop;
  return stop.passes || stop.seconds || stop.relative_error ? stop : kDefaultStop;
}

/// The option behind a place in the settings, which are named as in a job message.
std::string option_of(const std::string& pointer) {
  static constexpr std::pair<const char*, const char*> kOptions[] = {
      {"/photons_per_pass", "--photons"}, {"/film/width", "--size"},
      {"/film/height", "--size"},         {"/radius", "--radius"},
      {"/stop/passes", "--passes"},       {"/stop/seconds", "--seconds"},
      {"/stop/relative_error", "--error"}};
  for (const auto& [place, option] : kOptions) {
    if (pointer == place) return option;
  }
  return pointer;
}

/// Everything that can be refused before work begins.
int check(const RenderCommand& command) {
  for (const std::string& output : command.outputs) {
    if (!format_of(output)) return print_usage_error(output + ": a picture's name ends in .exr, .png or .jpg");
  }
  if (const auto settings = check_settings(command.photons, command.settings, stop_of(command)); !settings) {
    return print_usage_error(option_of(settings.error().where) + ": " + settings.error().message);
  }
  for (const std::string& output : command.outputs) {
    if (const auto writable = check_writable(output); !writable) return print_failure(output, writable.error());
  }
  if (command.report.empty()) return kExitOk;
  const auto writable = check_writable(command.report);
  return writable ? kExitOk : print_failure(command.report, writable.error());
}

Result<RenderTask> make_task(const RenderCommand& command, const Execution& execution, ProgressBar& bar,
                             StageSeconds& seconds) {
  const Stopwatch watch;
  bar.stage("loading " + command.scene);
  auto scene = load_scene(command.scene);
  if (!scene) return scene.error();
  const auto camera = find_camera(*scene, command.camera);
  if (!camera) return camera.error();
  seconds.load = watch.seconds();
  bar.stage("preparing the scene");
  auto prepared = prepare(*std::move(scene), execution);
  if (!prepared) return prepared.error();
  seconds.prepare = watch.seconds() - seconds.load;
  bar.stage("planning");
  auto task = make_render_task(*std::move(prepared), *camera, command.photons, command.settings, execution);
  seconds.plan = watch.seconds() - seconds.load - seconds.prepare;
  return task;
}

void print_warnings(const Scene& scene) {
  for (const std::string& warning : scene.warnings) std::cerr << "photond: warning: " + warning + "\n";
}

int write_results(const RenderCommand& command, const RenderTask& task, const Rendering& rendering,
                  StageSeconds& seconds) {
  const Stopwatch watch;
  const Image picture = film_picture(rendering.film);
  for (const std::string& output : command.outputs) {
    if (const auto written = write_picture(output, picture); !written)
      return print_failure(output, written.error());
  }
  seconds.encode = watch.seconds();
  if (command.report.empty()) return kExitOk;
  const std::string text = indented(render_json(command, stop_of(command), task, rendering, seconds));
  const auto written = write_file(command.report, std::as_bytes(std::span(text)));
  return written ? kExitOk : print_failure(command.report, written.error());
}

void print_summary(const RenderCommand& command, const RenderTask& task, const Rendering& rendering) {
  std::string text = std::string(method_name(task.plan.method)) + ": " + std::to_string(rendering.film.pass_count()) +
                     (rendering.film.pass_count() == 1 ? " pass in " : " passes in ") +
                     duration_text(rendering.seconds);
  if (const ErrorEstimate error = estimate_error(rendering.film); error.known) {
    text += ", estimated relative error " + std::to_string(error.relative);
  }
  text += " ->";
  for (const std::string& output : command.outputs) text += " " + output;
  std::cerr << text + "\n";
}

}  // namespace

int run_render(const RenderCommand& command) {
  if (const int code = check(command); code != kExitOk) return code;
  const Interrupt interrupt;
  const auto interrupted = [&] {
    std::cerr << "photond: interrupted before the first pass was done: nothing is written\n";
    return 128 + interrupt.signal();
  };
  const Workers workers(command.threads);
  lower_priority();
  const Execution execution = workers.execution(interrupt.token());

  StageSeconds seconds;
  auto bar = std::make_unique<ProgressBar>();
  const auto task = make_task(command, execution, *bar, seconds);
  if (!task) {
    bar.reset();
    return interrupt.signal() != 0 ? interrupted() : print_failure(command.scene, task.error());
  }
  const auto rendering = render_passes(*task, stop_of(command), execution, *bar);
  bar.reset();  // the line is erased before anything else is printed
  if (!rendering) return print_failure(command.scene, rendering.error());
  if (rendering->film.pass_count() == 0) return interrupted();
  if (const int code = write_results(command, *task, *rendering, seconds); code != kExitOk) return code;
  print_warnings(task->scene->scene);
  print_summary(command, *task, *rendering);
  return interrupt.signal() != 0 ? 128 + interrupt.signal() : kExitOk;
}

}  // namespace photond
