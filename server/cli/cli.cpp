#include "server/cli/cli.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <string>

#include "server/cli/commands.h"
#include "server/store/data_directory.h"

namespace photond {
namespace {

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
  app.add_option_function<float>(
         "--environment-rotation",
         [&environment](const float& degrees) {
           if (!(std::abs(degrees) <= 360)) throw CLI::ValidationError("--environment-rotation", "expects -360 to 360");
           environment.rotation_deg = degrees;
         },
         "Degrees by which it is turned about the vertical, +X towards -Z (default: 0)")
      ->needs(file);
  app.add_option_function<float>(
         "--environment-scale",
         [&environment](const float& scale) {
           if (!(scale >= 0 && scale <= 1e9f)) throw CLI::ValidationError("--environment-scale", "expects 0 to 1e9");
           environment.scale = scale;
         },
         "Factor of its radiance (default: 1)")
      ->needs(file);
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
  app.add_option("--photons", command.photons.photons_per_pass, "Photon paths emitted per pass")
      ->capture_default_str();
  app.add_option("--radius", command.settings.radius,
                 "Widest gather radius of the first pass in metres (default: chosen for each gather)");
  app.add_option_function<std::uint64_t>(
      "--seed", [&command](const std::uint64_t& seed) { command.settings.seed = command.photons.seed = seed; },
      "Number that selects the random sequence (default: 0)");
  app.add_option("--threads", command.threads, "Render threads (default: one per core)")
      ->check(CLI::Range(0, 1024).description(""));
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
  render->add_option("--passes", command.stop.passes, "Stop after this many passes");
  render->add_option("--seconds", command.stop.seconds, "Stop after this many seconds of rendering");
  render->add_option("--error", command.stop.relative_error,
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

void add_megabytes(CLI::App& app, const std::string& name, std::uint64_t& bytes,
                   const std::string& description) {
  constexpr std::uint64_t kMost = 1ull << 24;  // 16 TiB: keeps the shift below from overflowing
  app.add_option_function<std::uint64_t>(
         name, [&bytes](const std::uint64_t& mb) { bytes = mb << 20; },
         description + " (default: " + std::to_string(bytes >> 20) + ")")
      ->check(CLI::Range(std::uint64_t{0}, kMost).description(""))
      ->type_name("MB");
}

CLI::App* add_serve(CLI::App& app, ServiceOptions& options, LogLevel& log_level) {
  CLI::App* const serve = app.add_subcommand("serve", "Serve the HTTP interface and the web client");
  serve->add_option("--host", options.host, "Address to listen on")->capture_default_str();
  serve->add_option("--port", options.port, "Port to listen on; 0: any free one")
      ->check(CLI::Range(0, 65535).description(""))
      ->capture_default_str();
  serve->add_option("--cors-origin", options.cors_origins,
                    "Another site whose pages may use this service, as https://example.org; repeatable (default: none)");
  serve->add_flag("--insecure", options.insecure, "Serve an address that others can reach though no keys exist");
  options.data_dir = default_data_directory();
  serve->add_option("--data", options.data_dir,
                    "Folder for jobs, scenes, pictures, maps and keys (default: $XDG_DATA_HOME/photond or ~/.local/share/photond)");
  serve->add_option("--samples", options.samples_dir, "Folder of .glb files to offer as samples");
  serve->add_option("--client", options.client_dir, "Folder of the built web client");
  serve->add_option("--threads", options.threads, "Render threads (default: one per core)")
      ->check(CLI::Range(0, 1024).description(""));
  add_megabytes(*serve, "--map-cache-mb", options.map_cache_bytes, "Memory for cached photon maps");
  add_megabytes(*serve, "--map-disk-mb", options.map_disk_bytes, "Disk for cached photon maps; 0: none");
  add_megabytes(*serve, "--scene-cache-mb", options.scene_cache_bytes, "Memory for prepared scenes");
  add_megabytes(*serve, "--disk-quota-mb", options.disk_quota_bytes, "What the data folder may take; 0: no limit");
  add_megabytes(*serve, "--disk-reserve-mb", options.disk_reserve_bytes, "Space to leave free on its disk");
  add_megabytes(*serve, "--max-upload-mb", options.max_upload_bytes, "Largest upload");
  serve->add_option("--max-pixels", options.max_pixels, "Largest picture, in pixels")->capture_default_str();
  serve->add_option("--max-jobs", options.max_live_jobs, "Jobs waiting and running at once")
      ->capture_default_str();
  serve->add_option("--max-streams", options.max_streams, "Event streams and long polls at once")
      ->capture_default_str();
  serve->add_option_function<double>(
           "--drain-seconds",
           [&options](const double& seconds) {
             options.drain_time = std::chrono::milliseconds(static_cast<std::int64_t>(1000 * seconds));
           },
           "For running jobs to be put away after SIGTERM; the process then ends all the same (default: 18)")
      ->check(CLI::Range(0.0, 3600.0).description(""));
  const std::map<std::string, LogLevel> levels{{"debug", LogLevel::debug},
                                               {"info", LogLevel::info},
                                               {"warning", LogLevel::warning},
                                               {"error", LogLevel::error},
                                               {"off", LogLevel::off}};
  serve->add_option("--log-level", log_level, "Least level of the JSON lines on stderr (default: info)")
      ->transform(CLI::CheckedTransformer(levels, CLI::ignore_case).description(""))
      ->type_name("debug|info|warning|error|off");
  serve->add_option("--max-uploads", options.max_uploads, "Uploads at once")->capture_default_str();
  serve->add_option("--max-requests", options.max_requests, "Other requests at once")->capture_default_str();
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
  create->add_option("--max-jobs", command.limits.jobs, "Its jobs that have not ended");
  create->add_option_function<std::uint64_t>(
            "--max-mb", [&command](const std::uint64_t& mb) { command.limits.bytes = mb << 20; }, "Its uploaded scenes and environments, in MB")
      ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 24).description(""));
  create->add_option("--max-streams", command.limits.streams, "Event streams and long polls at once");
  add_action("list", "List the keys", KeyCommand::Action::list);
  add_action("revoke", "Forget a key; a running service refuses it from now on", KeyCommand::Action::revoke)
      ->add_option("ID", command.id, "As the list shows it")
      ->required();
  return key;
}

/// Help and version requests succeed and go to stdout; everything else is a usage error.
int print_parse_result(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) return app.exit(error);
  std::cerr << "photond: " << error.what() << " (see photond --help)\n";
  return kExitUsage;
}

}  // namespace

int print_usage_error(const std::string& message) {
  std::cerr << "photond: " + message + "\n";
  return kExitUsage;
}

int print_failure(const std::string& subject, const Error& error) {
  std::string text = "photond: " + subject;
  if (!error.where.empty()) text += (text.back() == ' ' ? "" : ": ") + error.where;
  std::cerr << text + ": " + error.message + "\n";
  return kExitFailure;
}

int run_cli(int argc, char** argv) {
  CLI::App app("photond renders glTF scenes with global illumination by photon mapping.", "photond");
  app.set_version_flag("--version", "photond " PHOTOND_VERSION);
  app.require_subcommand(1);
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
  if (render_app->parsed()) return run_render(render);
  if (task_app->parsed()) return run_task(task);
  if (merge_app->parsed()) return run_merge(merge);
  if (info_app->parsed()) return run_info(info);
  if (compare_app->parsed()) return run_compare(compare);
  if (key_app->parsed()) return run_key(key);
  return run_serve(service, log_level);
}

}  // namespace photond
