#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/film/film.h"
#include "core/render/settings.h"
#include "server/log.h"
#include "server/service.h"
#include "server/store/keys.h"

namespace photond {

/// A picture of the surroundings to light a scene with.
struct EnvironmentOptions {
  std::string file;        ///< EXR or HDR; empty: the scene's own environment
  float rotation_deg = 0;
  float scale = 1;
};

/// What determines a picture, and the threads to make it with.
struct TaskOptions {
  std::string scene;
  EnvironmentOptions environment;
  std::string camera;  ///< name or index; empty: the first
  PhotonSettings photons;
  RenderSettings settings;
  int threads = 0;     ///< 0: one per core
};

struct RenderCommand {
  TaskOptions task;
  std::vector<std::string> outputs;
  StopRule stop;          ///< empty: kDefaultStop
  std::string reference;  ///< EXR file; empty: none
  std::string report;     ///< JSON file; empty: none
};

/// Where a rendering ends if the command line does not say.
inline constexpr StopRule kDefaultStop = {.passes = {}, .seconds = 60.0, .relative_error = 0.02};

/// Renders exactly these passes into an accumulator file.
struct TaskCommand {
  TaskOptions task;
  PassRange passes;
  std::string output;
};

/// Joins accumulator files to the picture that one rendering of all their passes gives.
struct MergeCommand {
  std::vector<std::string> inputs;
  std::vector<std::string> outputs;
  std::string report;  ///< JSON file; empty: none
};

struct InfoCommand {
  std::string scene;
  EnvironmentOptions environment;
  bool json = false;
};

struct CompareCommand {
  std::string image;
  std::string reference;
  bool json = false;
};

/// Changes or shows the keys of a data directory.
struct KeyCommand {
  enum class Action { create, list, revoke };
  Action action = Action::list;
  std::string data;   ///< the folder of the service
  std::string scope;
  std::string label;
  KeyLimits limits;
  std::string id;     ///< to revoke
};

/// Each runs one command, prints its errors to stderr and returns the exit code (cli.h).
int run_render(const RenderCommand& command);
int run_task(const TaskCommand& command);
int run_merge(const MergeCommand& command);
int run_info(const InfoCommand& command);
int run_compare(const CompareCommand& command);
int run_serve(const ServiceOptions& options, LogLevel log_level);
int run_key(const KeyCommand& command);

/// Prints `photond: <message>` to stderr and returns kExitUsage.
int print_usage_error(const std::string& message);

/// Prints why outputs were refused, `photond: <where>: <message>`, and returns the exit code: kExitOk where they were not.
int print_refusal(const Status& outputs);

/// Prints `photond: <subject>: <where>: <message>` to stderr and returns kExitFailure.
int print_failure(const std::string& subject, const Error& error);

/// Sends what was printed to standard output on its way. Errors: io where not all of it could be written.
Status flush_output();

/// The end of a command whose result is what it has printed: tells where that could not be written, and returns the exit
/// code.
int finish_output();

}  // namespace photond
