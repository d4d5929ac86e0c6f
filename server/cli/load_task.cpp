#include "server/cli/load_task.h"

#include <utility>

#include "server/cli/cli.h"
#include "server/cli/load_scene.h"
#include "server/cli/stopwatch.h"

namespace photond {
namespace {

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

}  // namespace

int check_settings(const TaskOptions& options, const StopRule& stop) {
  const auto settings = check_settings(options.photons, options.settings, stop);
  if (settings) return kExitOk;
  return print_usage_error(option_of(settings.error().where) + ": " + settings.error().message);
}

Result<RenderTask> load_task(const TaskOptions& options, const Execution& execution, ProgressBar& bar,
                             LoadSeconds& seconds) {
  const Stopwatch watch;
  bar.stage("loading " + options.scene);
  auto scene = load_scene(options.scene, options.environment);
  if (!scene) return scene.error();
  const auto camera = find_camera(*scene, options.camera);
  if (!camera) return camera.error();
  seconds.load = watch.seconds();
  bar.stage("preparing the scene");
  auto prepared = prepare(*std::move(scene), execution);
  if (!prepared) return prepared.error();
  seconds.prepare = watch.seconds() - seconds.load;
  bar.stage("planning");
  auto task = make_render_task(*std::move(prepared), *camera, options.photons, options.settings, execution);
  seconds.plan = watch.seconds() - seconds.load - seconds.prepare;
  if (!task) return Error{task.error().code, task.error().message, option_of(task.error().where)};
  return task;
}

}  // namespace photond
