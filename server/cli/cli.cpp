#include "server/cli/cli.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>
#include <iostream>
#include <string>

#include "server/cli/commands.h"

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

void add_render_settings(CLI::App& app, RenderCommand& command) {
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
           if (!method) throw CLI::ValidationError("--method", "expects auto, path, photon_map or progressive");
           command.settings.method = *method;
         },
         "auto, path, photon_map or progressive (default: auto)")
      ->type_name("NAME");
  app.add_option("--photons", command.photons.photons_per_pass, "Photon paths emitted per pass")
      ->capture_default_str();
  app.add_option("--radius", command.settings.radius,
                 "First gather radius in metres (default: chosen for the scene)");
  app.add_option_function<std::uint64_t>(
      "--seed", [&command](const std::uint64_t& seed) { command.settings.seed = command.photons.seed = seed; },
      "Number that selects the random sequence (default: 0)");
}

CLI::App* add_render(CLI::App& app, RenderCommand& command) {
  CLI::App* const render = app.add_subcommand("render", "Render a glTF scene to picture files");
  render->add_option("SCENE", command.scene, "A .glb or .gltf file")->required();
  render
      ->add_option("-o,--output", command.outputs,
                   "Picture to write: .exr (linear float), .png or .jpg; repeatable")
      ->required()
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  add_render_settings(*render, command);
  render->add_option("--passes", command.stop.passes, "Stop after this many passes");
  render->add_option("--seconds", command.stop.seconds, "Stop after this many seconds of rendering");
  render->add_option("--error", command.stop.relative_error, "Stop below this estimated relative error");
  render->add_option("--threads", command.threads, "Render threads (default: one per core)")
      ->check(CLI::Range(0, 1024).description(""));
  render->add_option("--report", command.report, "Write a JSON report to this file");
  render->footer(
      "Without a stop option: 60 seconds or a relative error of 0.02, whichever comes first.\n"
      "Ctrl-C ends the rendering and writes what there is.");
  return render;
}

CLI::App* add_info(CLI::App& app, InfoCommand& command) {
  CLI::App* const info =
      app.add_subcommand("info", "Show what a glTF scene contains and how it would be rendered");
  info->add_option("SCENE", command.scene, "A .glb or .gltf file")->required();
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

CLI::App* add_serve(CLI::App& app, ServiceOptions& options) {
  CLI::App* const serve = app.add_subcommand("serve", "Serve the HTTP interface and the web client");
  serve->add_option("--host", options.host, "Address to listen on")->capture_default_str();
  serve->add_option("--port", options.port, "Port to listen on; 0: any free one")
      ->check(CLI::Range(0, 65535).description(""))
      ->capture_default_str();
  serve->add_option("--samples", options.samples_dir, "Folder of .glb files to offer as samples");
  serve->add_option("--client", options.client_dir, "Folder of the built web client");
  serve->add_option("--threads", options.threads, "Render threads (default: one per core)")
      ->check(CLI::Range(0, 1024).description(""));
  add_megabytes(*serve, "--map-cache-mb", options.map_cache_bytes, "Memory for cached photon maps");
  add_megabytes(*serve, "--scene-cache-mb", options.scene_cache_bytes, "Memory for prepared scenes");
  add_megabytes(*serve, "--scene-store-mb", options.scene_store_bytes, "Memory for uploaded files");
  add_megabytes(*serve, "--picture-mb", options.picture_bytes, "Memory for pictures of finished jobs");
  add_megabytes(*serve, "--max-upload-mb", options.max_upload_bytes, "Largest upload");
  serve->add_option("--max-pixels", options.max_pixels, "Largest picture, in pixels")->capture_default_str();
  serve->add_option("--max-jobs", options.max_live_jobs, "Jobs waiting and running at once")
      ->capture_default_str();
  serve->add_option("--max-streams", options.max_streams, "Event streams and long polls at once")
      ->capture_default_str();
  return serve;
}

/// Help and version requests succeed and go to stdout; everything else is a usage error.
int print_parse_result(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) return app.exit(error);
  std::cerr << "photond: " << error.what() << " (see photond --help)\n";
  return kExitUsage;
}

}  // namespace

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
  InfoCommand info;
  CompareCommand compare;
  ServiceOptions service;
  const CLI::App* const render_app = add_render(app, render);
  const CLI::App* const info_app = add_info(app, info);
  const CLI::App* const compare_app = add_compare(app, compare);
  add_serve(app, service);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return print_parse_result(app, error);
  }
  if (render_app->parsed()) return run_render(render);
  if (info_app->parsed()) return run_info(info);
  if (compare_app->parsed()) return run_compare(compare);
  return run_serve(service);
}

}  // namespace photond
