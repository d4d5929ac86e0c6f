#include "tests/cli/program.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

extern char** environ;

namespace photond::test {

pid_t spawn_photond(const std::vector<std::string>& arguments, const std::string& out, const std::string& err) {
  std::vector<char*> argv;
  std::string program = PHOTOND_PROGRAM;
  argv.push_back(program.data());
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  pid_t pid = -1;
  const int failure = posix_spawn(&pid, program.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) throw std::runtime_error("cannot start " + program);
  return pid;
}

int wait_for_exit(pid_t pid) {
  int status = 0;
  waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

Outcome run_photond(const std::vector<std::string>& arguments, double interrupt) {
  const TemporaryFolder folder;
  const pid_t pid = spawn_photond(arguments, folder.file("out"), folder.file("err"));
  if (interrupt > 0) {
    std::this_thread::sleep_for(std::chrono::duration<double>(interrupt));
    kill(pid, SIGINT);
  }
  return {.code = wait_for_exit(pid),
          .out = read_text(folder.path() / "out"),
          .err = read_text(folder.path() / "err")};
}

std::string read_text(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

std::string write_scene(const std::filesystem::path& folder, const std::string& buffer) {
  const float positions[] = {-1,   0, -1,   -1,  0, 1,    1,   0, 1,   1,    0, -1,    // floor
                             -.3f, 1, -.3f, .3f, 1, -.3f, .3f, 1, .3f, -.3f, 1, .3f};  // lamp, facing down
  const std::uint16_t indices[] = {0, 1, 2, 0, 2, 3};
  std::string bytes(reinterpret_cast<const char*>(positions), sizeof positions);
  bytes.append(reinterpret_cast<const char*>(indices), sizeof indices);
  write_text(folder / "scene.bin", bytes);
  write_text(folder / "scene.gltf", R"({"asset": {"version": "2.0"}, "scene": 0,
 "scenes": [{"nodes": [0, 1, 2]}],
 "nodes": [{"mesh": 0}, {"mesh": 1}, {"camera": 0, "name": "above", "translation": [0, 0.8, 3]}],
 "cameras": [{"name": "above", "type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
 "meshes": [
  {"primitives": [{"attributes": {"POSITION": 0}, "indices": 2, "material": 0}]},
  {"primitives": [{"attributes": {"POSITION": 1}, "indices": 2, "material": 1}]}],
 "materials": [
  {"name": "white", "pbrMetallicRoughness": {"baseColorFactor": [0.7, 0.7, 0.7, 1], "metallicFactor": 0}},
  {"name": "lamp", "emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}}],
 "accessors": [
  {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, -1], "max": [1, 0, 1]},
  {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-0.3, 1, -0.3], "max": [0.3, 1, 0.3]},
  {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}],
 "bufferViews": [
  {"buffer": 0, "byteOffset": 0, "byteLength": 48},
  {"buffer": 0, "byteOffset": 48, "byteLength": 48},
  {"buffer": 0, "byteOffset": 96, "byteLength": 12}],
 "buffers": [{"uri": ")" + buffer + R"(", "byteLength": 108}]})");
  return (folder / "scene.gltf").string();
}

}  // namespace photond::test
