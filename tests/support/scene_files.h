#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/scene/gltf.h"

namespace photond::test {

/// The folder of shared test scenes: PHOTOND_SCENES, or beside the checkout; nothing where there is none.
std::optional<std::filesystem::path> shared_scenes();

/// The whole file; empty where it cannot be read.
std::vector<std::byte> read_file(const std::filesystem::path& path);

/// Serves the files of one folder, and records in `asked` what it was asked for.
ResourceReader folder_reader(const std::filesystem::path& folder, std::vector<std::string>* asked = nullptr);

}  // namespace photond::test
