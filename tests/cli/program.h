#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace photond::test {

/// What a finished run of the program left.
struct Outcome {
  int code = -1;  ///< exit code, or 128 + the signal that killed it
  std::string out;
  std::string err;
};

/// Starts the built program with its output in these files; the caller waits for it.
pid_t spawn_photond(const std::vector<std::string>& arguments, const std::string& out, const std::string& err);

/// Waits for the end of a process; returns its exit code, or 128 + the signal that killed it.
int wait_for_exit(pid_t pid);

/// Runs the built program with its output in files (so: no terminal) and waits for its end. With `interrupt`,
/// SIGINT is sent that many seconds after the start.
Outcome run_photond(const std::vector<std::string>& arguments, double interrupt = 0);

std::string read_text(const std::filesystem::path& file);
void write_text(const std::filesystem::path& file, const std::string& text);

/// Writes `scene.gltf` and its buffer `scene.bin` into the folder and returns the path of the former: a white
/// floor of 2 m × 2 m below a square lamp, with a camera named "above". `buffer` is the buffer's URI.
std::string write_scene(const std::filesystem::path& folder, const std::string& buffer = "scene.bin");

}  // namespace photond::test
