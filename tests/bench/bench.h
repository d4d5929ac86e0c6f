#pragma once

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <vector>

#include "core/scene/gltf.h"
#include "core/trace/prepare.h"

namespace photond::bench {

inline double seconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

inline Result<std::shared_ptr<const PreparedScene>> load(const std::filesystem::path& path, const Execution& execution) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> chars{std::istreambuf_iterator<char>(file), {}};
  auto scene = read_gltf(std::as_bytes(std::span(chars)), no_resources());
  if (!scene) return scene.error();
  return prepare(std::move(scene).value(), execution);
}

/// The samples, in alphabetical order.
inline std::vector<std::filesystem::path> samples() {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(PHOTOND_SAMPLES_DIR)) {
    if (entry.path().extension() == ".glb") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

}  // namespace photond::bench
