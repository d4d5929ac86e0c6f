// The error of each method against time, measured against reference pictures: a table and a figure per scene.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "server/cli/files.h"
#include "server/cli/load_scene.h"
#include "server/cli/picture.h"
#include "tests/bench/error_series.h"
#include "tests/bench/log_log_plot.h"

namespace photond::bench {
namespace {

namespace fs = std::filesystem;

// What the renderings of one scene have in common.
struct Subject {
  std::string name;
  std::shared_ptr<const PreparedScene> scene;
  Camera camera;
  Image reference;
  double floor = 0;       // of relMSE: the reference's own noise; 0 where it is not known
  Method automatic = Method::automatic;  // what `auto` chooses
};

struct Series {
  Method method;
  std::vector<ErrorRecord> records;
};

/// NAME_reference.exr, or NAME_stderr.exr, beside NAME.glb.
fs::path beside(const fs::path& scene, const char* what) {
  return scene.parent_path() / (scene.stem().string() + "_" + what + ".exr");
}

// The scenes of a folder that have a reference, in alphabetical order.
std::vector<fs::path> scenes_with_references(const fs::path& folder) {
  std::vector<fs::path> scenes;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    const fs::path& path = entry.path();
    if (path.extension() == ".glb" && fs::exists(beside(path, "reference"))) scenes.push_back(path);
  }
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

// The expected relMSE of the truth against the reference: the mean of σ²/(r² + 0.01).
double noise_floor(const Image& reference, const Image& standard_error) {
  double sum = 0;
  for (std::size_t i = 0; i < reference.pixels.size(); ++i) {
    const glm::dvec3 r(reference.pixels[i]), s(standard_error.pixels[i]);
    const glm::dvec3 ratio = s * s / (r * r + 0.01);
    sum += (ratio.x + ratio.y + ratio.z) / 3;
  }
  return sum / static_cast<double>(reference.pixels.size());
}

Result<double> read_floor(const fs::path& scene, const Image& reference) {
  if (!fs::exists(beside(scene, "stderr"))) return 0.0;
  const auto standard_error = read_picture(beside(scene, "stderr"));
  if (!standard_error) return standard_error.error();
  if (standard_error->width != reference.width || standard_error->height != reference.height) {
    return invalid_input("the standard error's size is not the reference's");
  }
  return noise_floor(reference, *standard_error);
}

RenderSettings settings_of(const Image& reference, Method method) {
  RenderSettings settings;
  settings.method = method;
  settings.width = reference.width;
  settings.height = reference.height;
  return settings;
}

Result<Subject> load_subject(const fs::path& path, const std::string& camera_name, const Execution& execution) {
  auto reference = read_picture(beside(path, "reference"));
  if (!reference) return reference.error();
  const auto floor = read_floor(path, *reference);
  if (!floor) return floor.error();
  auto scene = load_scene(path);
  if (!scene) return scene.error();
  const auto camera = find_camera(*scene, camera_name);
  if (!camera) return camera.error();
  auto prepared = prepare(*std::move(scene), execution);
  if (!prepared) return prepared.error();
  const auto task = make_render_task(*prepared, *camera, {}, settings_of(*reference, Method::automatic), execution);
  if (!task) return task.error();
  return Subject{path.stem().string(), *std::move(prepared), *camera, *std::move(reference), *floor, task->plan.method};
}

Result<Series> render(const Subject& subject, Method method, const std::vector<double>& times,
                      const Execution& execution) {
  const auto task =
      make_render_task(subject.scene, subject.camera, {}, settings_of(subject.reference, method), execution);
  if (!task) return task.error();
  auto records = error_series(*task, subject.reference, times, execution);
  if (!records) return records.error();
  return Series{method, *std::move(records)};
}

std::vector<TimePoint> true_errors(const Series& series) {
  std::vector<TimePoint> points;
  for (const ErrorRecord& r : series.records) {
    if (r.rel_mse > 0) points.push_back({r.seconds, r.rel_mse});
  }
  return points;
}

// From five seconds on, when setting out no longer counts, and as long as the reference's noise is the smaller part.
// Of what is measured, or of that less `noise`: relMSE is on average the sum of the picture's own and the reference's.
std::optional<double> slope(const Subject& subject, const Series& series, double noise) {
  std::vector<TimePoint> points = true_errors(series);
  std::erase_if(points, [&](const TimePoint& p) { return p.seconds < 5 || p.value < 2 * subject.floor; });
  for (TimePoint& p : points) p.value -= noise;
  return fitted_exponent(points);
}

std::string label(const Subject& subject, Method method) {
  return std::string(method_name(method)) + (method == subject.automatic ? " (auto)" : "");
}

// The columns of the table: 2.5, 5, 10 … seconds, and the end.
std::vector<double> columns(const std::vector<double>& times) {
  std::vector<double> out;
  for (double t = 2.5; t < times.back(); t *= 2) out.push_back(t);
  out.push_back(times.back());
  return out;
}

void print_header(const Subject& subject, const std::vector<double>& times) {
  std::printf("\n%s, %d×%d: relMSE after", subject.name.c_str(), subject.reference.width, subject.reference.height);
  if (subject.floor > 0) std::printf(" (the reference's own noise: %.2g)", subject.floor);
  std::printf("\n%-20s", "method");
  for (const double t : columns(times)) std::printf(" %7g s", t);
  std::printf(" %7s %7s %9s %9s %8s\n", "slope", "own", "est/true", "8×8", "passes");
}

void print_row(const Subject& subject, const Series& series, const std::vector<double>& times) {
  std::printf("%-20s", label(subject, series.method).c_str());
  for (const double t : columns(times)) {
    const auto at = std::find_if(series.records.begin(), series.records.end(),
                                 [t](const ErrorRecord& r) { return r.seconds == t; });
    at == series.records.end() ? std::printf(" %9s", "-") : std::printf(" %9.2e", at->rel_mse);
  }
  for (const double noise : {0.0, subject.floor}) {
    const auto exponent = slope(subject, series, noise);
    exponent ? std::printf(" %7.2f", *exponent) : std::printf(" %7s", "-");
  }
  if (series.records.empty()) {
    std::printf("  no pass was done in time\n");
  } else {
    const ErrorRecord& end = series.records.back();
    std::printf(" %9.2f %7.2f%% %8u\n", end.estimated / end.rel_mse, 100 * end.median_block_deviation, end.passes);
  }
  std::fflush(stdout);
}

Status write_figure(const fs::path& folder, const Subject& subject, const std::vector<Series>& all) {
  LogLogPlot plot{subject.name, "seconds", "relMSE", {}, std::nullopt};
  for (const Series& series : all) plot.lines.push_back({label(subject, series.method), true_errors(series)});
  if (subject.floor > 0) plot.level = {"noise of the reference", subject.floor};
  const std::string svg = to_svg(plot);
  return write_file(folder / (subject.name + ".svg"), std::as_bytes(std::span(svg)));
}

Status measure_scene(const fs::path& path, const std::string& camera, const std::vector<Method>& methods,
                     const std::vector<double>& times, const fs::path& folder, const Execution& execution) {
  const auto subject = load_subject(path, camera, execution);
  if (!subject) return subject.error();
  print_header(*subject, times);
  std::vector<Series> all;
  for (const Method method : methods) {
    auto series = render(*subject, method, times, execution);
    if (!series) return series.error();
    print_row(*subject, *series, times);
    all.push_back(*std::move(series));
  }
  return write_figure(folder, *subject, all);
}

// Every method there is; `auto` is one of them.
std::vector<Method> all_methods() {
  std::vector<Method> methods;
  for (const char* name : {"hybrid", "progressive", "photon_map", "path"}) {
    if (const auto method = method_from_name(name)) methods.push_back(*method);
  }
  return methods;
}

fs::path shared_folder() {
  const char* chosen = std::getenv("PHOTOND_SCENES");
  return fs::path(chosen != nullptr ? chosen : PHOTOND_SHARED_SCENES) / "gi";
}

}  // namespace
}  // namespace photond::bench

int main(int argc, char** argv) {
  using namespace photond;
  using namespace photond::bench;
  CLI::App app{"The error of each method against time: a table and a figure per scene, methods one after the other"};
  std::vector<std::string> scenes, names;
  std::string camera = "main", folder = PHOTOND_FIGURES_DIR;
  double duration = 160;
  int threads = 0;
  app.add_option("scenes", scenes, "NAME.glb files with a NAME_reference.exr beside them; default: the shared scenes");
  app.add_option("--method", names, "default: all")->check([](const std::string& name) {
    return method_from_name(name.c_str()) ? std::string() : "there is no method " + name;
  });
  app.add_option("--seconds", duration, "of each rendering")->check(CLI::Range(0.1, 1e6));
  app.add_option("--camera", camera);
  app.add_option("--threads", threads, "0: one per core")->check(CLI::Range(0, 1024));
  app.add_option("--out", folder, "where the figures go");
  CLI11_PARSE(app, argc, argv);

  std::vector<std::filesystem::path> paths(scenes.begin(), scenes.end());
  if (paths.empty()) paths = scenes_with_references(shared_folder());
  if (paths.empty()) {
    std::fprintf(stderr, "no scene with a reference in %s: name some, or set PHOTOND_SCENES\n",
                 shared_folder().c_str());
    return 1;
  }
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure) {
    std::fprintf(stderr, "%s: %s\n", folder.c_str(), failure.message().c_str());
    return 1;
  }
  std::vector<Method> methods;
  for (const std::string& name : names) methods.push_back(*method_from_name(name.c_str()));
  if (methods.empty()) methods = all_methods();

  const Workers workers(threads);
  for (const auto& path : paths) {
    const Status done = measure_scene(path, camera, methods, measured_times(duration), folder, workers.execution());
    if (done) continue;
    std::fprintf(stderr, "%s: %s %s\n", path.c_str(), done.error().message.c_str(), done.error().where.c_str());
    return 1;
  }
  std::printf("\nfigures: %s\n", folder.c_str());
  return 0;
}
