#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/render/settings.h"
#include "server/service.h"

namespace photond {

struct RenderCommand {
  std::string scene;
  std::vector<std::string> outputs;
  std::string camera;  ///< name or index; empty: the first
  PhotonSettings photons;
  RenderSettings settings;
  StopRule stop;       ///< empty: kDefaultStop
  int threads = 0;     ///< 0: one per core
  std::string report;  ///< JSON file; empty: none
};

/// Where a rendering ends if the command line does not say.
inline constexpr StopRule kDefaultStop = {.passes = {}, .seconds = 60.0, .relative_error = 0.02};

struct InfoCommand {
  std::string scene;
  bool json = false;
};

struct CompareCommand {
  std::string image;
  std::string reference;
  bool json = false;
};

/// Each runs one command, prints its errors to stderr and returns the exit code (cli.h).
int run_render(const RenderCommand& command);
int run_info(const InfoCommand& command);
int run_compare(const CompareCommand& command);
int run_serve(const ServiceOptions& options);

/// Prints `photond: <subject>: <where>: <message>` to stderr and returns kExitFailure.
int print_failure(const std::string& subject, const Error& error);

}  // namespace photond
