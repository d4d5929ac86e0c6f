#include "server/cli/cli.h"

#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <map>
#include <string>

#include "server/cli/commands.h"
#include "server/cli/options.h"
#include "server/cli/printable.h"
#include "server/store/data_directory.h"

namespace photond {
namespace {

constexpr Range<double> kAny{-INFINITY, INFINITY};  ///< check_settings knows better

/// Parses "WxH".
bool parse_size(const std::string& text, RenderSettings& settings) {
  const char* const end = text.data() + text.size();
  const auto [x, width_error] = std::from_chars(text.data(), end, settings.width);
  if (width_error != std::errc{} || x == end || *x != 'x') return false;
  const auto [last, height_error] = std::from_chars(x + 1, end, settings.height);
  return height_error == std::errc{} && last == end;
}

/// Parses "A:B" with A < B.
bool parse_passes(const std::string& text, PassRange& passes) {
  const char* const end = text.data() + text.size();
  const auto [colon, first_error] = std::from_chars(text.data(), end, passes.first);
  if (first_error != std::errc{} || colon == end || *colon != ':') return false;
  const auto [last, last_error] = std::from_chars(colon + 1, end, passes.last);
  return last_error == std::errc{} && last == end && passes.first < passes.last;
}

void add_environment_options(CLI::App& app, EnvironmentOptions& environment) {
  CLI::Option* const file = app.add_option("--environment", environment.file,
                                           "Light the scene from around by this equirectangular .exr or .hdr file");
  add_number(app, "--environment-rotation",
             [&environment](double degrees) { environment.rotation_deg = static_cast<float>(degrees); }, {-360, 360},
             "Degrees by which it is turned about the vertical, +X towards -Z (default: 0)")
      ->needs(file);
  add_number(app, "--environment-scale",
             [&environment](double scale) { environment.scale = static_cast<float>(scale); }, {0, 1e9},
             "Factor of its radiance (default: 1)")
      ->needs(file);
}

void add_threads(CLI::App& app, int& threads) {
  add_whole<int>(app, "--threads", [&threads](int count) { threads = count; }, {0, 1024},
                 "Render threads (default: one per core)");
}

void add_task_options(CLI::App& app, TaskOptions& command) {
  app.add_option("SCENE", command.scene, "A .glb or .gltf file")->required();
  add_environment_options(app, command.environment);
  app.add_option("--camera", command.camera, "Name or index of the camera (default: the first)");
  app.add_option_function<std::string>(
         "--size",
         [&command](const std::string& text) {
           if (!parse_size(text, command.settings))
             throw CLI::ValidationError("--size", "expects WxH, as 640x360");
         },
         "Pixels of the picture, as 640x360 (default: 512x512)")
      ->type_name("WxH");
  app.add_option_function<std::string>(
         "--method",
         [&command](const std::string& text) {
           const auto method = method_from_name(text.c_str());
           if (!method) throw CLI::ValidationError("--method", "expects auto, path, photon_map, progressive or hybrid");
           command.settings.method = *method;
         },
         "auto, path, photon_map, progressive or hybrid (default: auto)")
      ->type_name("NAME");
  const CLI::Option* const photons = add_whole<std::uint32_t>(
      app, "--photons", [&command](std::uint32_t count) { command.photons.photons_per_pass = count; },
      {1, 100'000'000},
      "Photon paths of a pass, or a share where they are directed (default: about one per pixel, 262144 to 4194304; "
      "fewer below 128x128)");
  app.parse_complete_callback([&command, photons] {
    if (photons->empty()) command.photons.photons_per_pass = default_photons(command.settings);
  });
  add_number(app, "--radius", [&command](double radius) { command.settings.radius = static_cast<float>(radius); }, kAny,
             "Widest gather radius of the first pass in metres (default: chosen for each gather)");
  add_whole<std::uint64_t>(
      app, "--seed", [&command](std::uint64_t seed) { command.settings.seed = command.photons.seed = seed; },
      {0, UINT64_MAX}, "Number that selects the random sequence (default: 0)");
  add_threads(app, command.threads);
}

void add_outputs(CLI::App& app, std::vector<std::string>& outputs, std::string& report) {
  app.add_option("-o,--output", outputs,
                 "Picture to write: .exr (linear float, with the layers error.noise, error.bias and error.bound), "
                 ".png or .jpg; repeatable")
      ->required()
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false);  // one file after each -o: what follows may be an input
  app.add_option("--report", report, "Write a JSON report to this file");
}

CLI::App* add_render(CLI::App& app, RenderCommand& command) {
  CLI::App* const render = app.add_subcommand("render", "Render a glTF scene to picture files");
  add_task_options(*render, command.task);
  add_outputs(*render, command.outputs, command.report);
  add_whole<std::uint32_t>(*render, "--passes", [&command](std::uint32_t passes) { command.stop.passes = passes; },
                           {1, UINT32_MAX}, "Stop after this many passes");
  add_number(*render, "--seconds", [&command](double seconds) { command.stop.seconds = seconds; }, kAny,
             "Stop after this many seconds of rendering");
  add_number(*render, "--error", [&command](double error) { command.stop.relative_error = error; }, kAny,
             "Stop below this estimated relative error, noise and bias together");
  render->add_option("--reference", command.reference, "EXR file of the true picture: report the true error as well");
  render->footer(
      "Without a stop option: 60 seconds or a relative error of 0.02, whichever comes first.\n"
      "Ctrl-C ends the rendering and writes what there is.");
  return render;
}

CLI::App* add_task(CLI::App& app, TaskCommand& command) {
  CLI::App* const task = app.add_subcommand("task", "Render some passes of a picture, to be merged");
  add_task_options(*task, command.task);
  task->add_option_function<std::string>(
          "--passes",
          [&command](const std::string& text) {
            if (!parse_passes(text, command.passes))
              throw CLI::ValidationError("--passes", "expects A:B, as 32:48 for the passes 32 to 47");
          },
          "Passes to render, as 32:48 for 32 to 47")
      ->required()
      ->type_name("A:B");
  task->add_option("-o,--out", command.output, "Accumulator file to write")->required();
  return task;
}

CLI::App* add_merge(CLI::App& app, MergeCommand& command) {
  CLI::App* const merge =
      app.add_subcommand("merge", "Join the passes of several tasks to the picture that one rendering gives");
  merge->add_option("ACCUMULATORS", command.inputs, "Files of photond task: passes 0 to N, each once")->required();
  add_outputs(*merge, command.outputs, command.report);
  return merge;
}

CLI::App* add_info(CLI::App& app, InfoCommand& command) {
  CLI::App* const info =
      app.add_subcommand("info", "Show what a glTF scene contains and how it would be rendered");
  info->add_option("SCENE", command.scene, "A .glb or .gltf file")->required();
  add_environment_options(*info, command.environment);
  info->add_flag("--json", command.json, "Print JSON");
  return info;
}

CLI::App* add_compare(CLI::App& app, CompareCommand& command) {
  CLI::App* const compare = app.add_subcommand("compare", "Measure how far a picture is from a reference");
  compare->add_option("IMAGE", command.image, "EXR file")->required();
  compare->add_option("REFERENCE", command.reference, "EXR file of the same size")->required();
  compare->add_flag("--json", command.json, "Print JSON");
  return compare;
}

constexpr std::uint64_t kMaxMegabytes = 1ull << 24;  // 16 TiB: keeps shifts to bytes from overflowing

void add_megabytes(CLI::App& app, const std::string& name, std::uint64_t& bytes,
                   const std::string& description) {
  add_whole<std::uint64_t>(app, name, [&bytes](std::uint64_t mb) { bytes = mb << 20; }, {0, kMaxMegabytes},
                           description + " (default: " + std::to_string(bytes >> 20) + ")")
      ->type_name("MB");
}

void add_log_level(CLI::App& app, LogLevel& log_level) {
  const std::map<std::string, LogLevel> levels{{"debug", LogLevel::debug},
                                               {"info", LogLevel::info},
                                               {"warning", LogLevel::warning},
                                               {"error", LogLevel::error},
                                               {"off", LogLevel::off}};
  app.add_option_function<std::string>(
         "--log-level",
         [levels, &log_level](const std::string& text) {
           const auto level = levels.find(text);
           if (level == levels.end()) {
             throw CLI::ValidationError("--log-level", "expects debug, info, warning, error or off");
           }
           log_level = level->second;
         },
         "Least level of the JSON lines on stderr (default: info)")
      ->type_name("NAME");
}

void add_count(CLI::App& app, const std::string& name, int& count, Range<int> range, const std::string& description) {
  add_whole<int>(app, name, [&count](int n) { count = n; }, range,
                 description + " (default: " + std::to_string(count) + ")");
}

CLI::App* add_serve(CLI::App& app, ServiceOptions& options, LogLevel& log_level) {
  CLI::App* const serve = app.add_subcommand("serve", "Serve the HTTP interface and the web client");
  serve->add_option("--host", options.host, "Address to listen on")->capture_default_str();
  add_count(*serve, "--port", options.port, {0, 65'535}, "Port to listen on; 0: any free one");
  serve->add_option("--cors-origin", options.cors_origins,
                    "Another site whose pages may use this service, as https://example.org; their pictures from here "
                    "need <img crossorigin>; repeatable (default: none)");
  serve->add_flag("--insecure", options.insecure, "Serve an address that others can reach though no keys exist");
  options.data_dir = default_data_directory();
  serve->add_option("--data", options.data_dir,
                    "Folder for jobs, scenes, pictures, maps and keys (default: $XDG_DATA_HOME/photond or ~/.local/share/photond)");
  serve->add_option("--samples", options.samples_dir, "Folder of .glb files to offer as samples");
  serve->add_option("--client", options.client_dir, "Folder of the built web client");
  add_threads(*serve, options.threads);
  add_megabytes(*serve, "--map-cache-mb", options.map_cache_bytes, "Memory for cached photon maps");
  add_megabytes(*serve, "--map-disk-mb", options.map_disk_bytes, "Disk for cached photon maps; 0: none");
  add_megabytes(*serve, "--scene-cache-mb", options.scene_cache_bytes, "Memory for prepared scenes");
  add_megabytes(*serve, "--disk-quota-mb", options.disk_quota_bytes, "What the data folder may take; 0: no limit");
  add_megabytes(*serve, "--disk-reserve-mb", options.disk_reserve_bytes, "Space to leave free on its disk");
  add_megabytes(*serve, "--max-upload-mb", options.max_upload_bytes, "Largest upload");
  add_whole<std::uint64_t>(*serve, "--max-pixels", [&options](std::uint64_t pixels) { options.max_pixels = pixels; },
                           {1, std::uint64_t{1} << 28},  // of 16384 by 16384, the largest film
                           "Largest picture, in pixels (default: " + std::to_string(options.max_pixels) + ")");
  add_megabytes(*serve, "--max-job-memory-mb", options.max_job_memory_bytes,
                "Memory for film and photon maps of one job, and for the films of all that take turns; half of what "
                "there is");
  add_count(*serve, "--max-jobs", options.max_live_jobs, {1, 1'000'000}, "Jobs waiting and running at once");
  add_count(*serve, "--max-streams", options.max_streams, {1, kMaxSeats}, "Event streams and long polls at once");
  add_count(*serve, "--max-uploads", options.max_uploads, {1, kMaxSeats}, "Uploads at once");
  add_count(*serve, "--max-requests", options.max_requests, {1, kMaxSeats}, "Other requests at once");
  add_number(
      *serve, "--drain-seconds",
      [&options](double seconds) {
        options.drain_time = std::chrono::milliseconds(static_cast<std::int64_t>(1000 * seconds));
      },
      {0, 3600}, "For running jobs to be put away after SIGTERM; the process then ends all the same (default: 18)");
  add_log_level(*serve, log_level);
  return serve;
}

CLI::App* add_key(CLI::App& app, KeyCommand& command) {
  CLI::App* const key = app.add_subcommand("key", "Make, list and revoke the keys that clients of a service need");
  key->require_subcommand(1);
  command.data = default_data_directory();
  const auto add_action = [&](const char* name, const char* description, KeyCommand::Action action) {
    CLI::App* const one = key->add_subcommand(name, description);
    one->add_option("--data", command.data, "Folder of the service (default: as of serve)");
    one->callback([&command, action] { command.action = action; });
    return one;
  };
  CLI::App* const create = add_action("create", "Print a new key; it is shown this once", KeyCommand::Action::create);
  create->add_option("--scope", command.scope, "read: look; submit: and upload, render, and change what came with it; admin: and change everything")
      ->required()
      ->check(CLI::IsMember({"read", "submit", "admin"}).description(""));
  create->add_option("--label", command.label, "What the list shows beside it");
  KeyLimits& limits = command.limits;
  constexpr Range<std::uint64_t> kCounts{0, 1'000'000};
  add_whole<std::uint64_t>(*create, "--max-jobs", [&limits](std::uint64_t jobs) { limits.jobs = jobs; }, kCounts,
                           "Its jobs that have not ended");
  add_whole<std::uint64_t>(*create, "--max-mb", [&limits](std::uint64_t mb) { limits.bytes = mb << 20; },
                           {0, kMaxMegabytes}, "Its uploaded scenes and environments, in MB");
  add_whole<std::uint64_t>(*create, "--max-streams", [&limits](std::uint64_t streams) { limits.streams = streams; },
                           kCounts, "Event streams and long polls at once");
  add_action("list", "List the keys", KeyCommand::Action::list);
  add_action("revoke", "Forget a key; a running service refuses it from now on", KeyCommand::Action::revoke)
      ->add_option("ID", command.id, "As the list shows it")
      ->required();
  return key;
}

/// Takes the places of standard streams that were closed, so that no file gets them, and what is printed with them. What
/// is printed to such a stream fails.
void fill_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) == -1) [[maybe_unused]] const int opened = ::open("/dev/null", O_RDONLY);
  }
}

/// Help and version requests succeed and go to stdout; everything else is a usage error.
int print_parse_result(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
    app.exit(error);
    return finish_output();
  }
  std::string command = "photond";
  for (const CLI::App* part = &app; !part->get_subcommands().empty();) {
    part = part->get_subcommands().front();
    command += " " + part->get_name();
  }
  std::cerr << "photond: " << error.what() << " (see " << command << " --help)\n";
  return kExitUsage;
}

}  // namespace

int print_usage_error(const std::string& message) {
  std::cerr << "photond: " + message + "\n";
  return kExitUsage;
}

int print_refusal(const Status& outputs) {
  if (outputs) return kExitOk;
  const Error& error = outputs.error();
  if (error.code == ErrorCode::invalid_input) return print_usage_error(error.where + ": " + error.message);
  return print_failure(error.where, {error.code, error.message, {}});
}

int print_failure(const std::string& subject, const Error& error) {
  std::string text = "photond: " + subject;
  if (!error.where.empty()) text += (text.back() == ' ' ? "" : ": ") + error.where;
  std::cerr << printable(text + ": " + error.message) + "\n";
  return kExitFailure;
}

Status flush_output() {
  errno = 0;
  std::cout.flush();
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout) return Done{};
  const std::string reason = errno != 0 ? std::string(": ") + std::strerror(errno) : "";
  return Error{ErrorCode::io, "cannot be written" + reason, "standard output"};
}

int finish_output() {
  const Status written = flush_output();
  return written ? kExitOk : print_refusal(written);
}

int run_cli(int argc, char** argv) {
  fill_standard_streams();
  // A reader that has gone, or a limit to the size of files, is an error of one write, not of the program.
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
  CLI::App app("photond renders glTF scenes with global illumination by photon mapping.", "photond");
  app.set_version_flag("--version", "photond " PHOTOND_VERSION);
  app.require_subcommand(0, 1);  // not 1: a misspelt one would be told as a missing one
  RenderCommand render;
  TaskCommand task;
  MergeCommand merge;
  InfoCommand info;
  CompareCommand compare;
  ServiceOptions service;
  LogLevel log_level = LogLevel::info;
  const CLI::App* const render_app = add_render(app, render);
  const CLI::App* const task_app = add_task(app, task);
  const CLI::App* const merge_app = add_merge(app, merge);
  const CLI::App* const info_app = add_info(app, info);
  const CLI::App* const compare_app = add_compare(app, compare);
  add_serve(app, service, log_level);
  KeyCommand key;
  const CLI::App* const key_app = add_key(app, key);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return print_parse_result(app, error);
  }
  if (app.get_subcommands().empty()) return print_usage_error("a command is required (see photond --help)");
  if (render_app->parsed()) return run_render(render);
  if (task_app->parsed()) return run_task(task);
  if (merge_app->parsed()) return run_merge(merge);
  if (info_app->parsed()) return run_info(info);
  if (compare_app->parsed()) return run_compare(compare);
  if (key_app->parsed()) return run_key(key);
  return run_serve(service, log_level);
}

}  // namespace photond
