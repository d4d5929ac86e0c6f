#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/scene/gltf.h"
#include "core/scene/scene.h"
#include "server/cli/commands.h"

namespace photond {

/// A reader of the files below `folder` for the resources of a .gltf. Refuses absolute paths, `..` and symbolic
/// links that lead outside, with invalid_input. Messages name the resource.
ResourceReader folder_resources(const std::filesystem::path& folder);

/// Reads a .glb or .gltf file with the resources in its own folder. Errors: those of read_gltf and of the
/// files.
Result<Scene> load_scene(const std::filesystem::path& file);

/// The same, lit from around as the options say. Errors: also those of the environment's file, which is named.
Result<Scene> load_scene(const std::filesystem::path& file, const EnvironmentOptions& environment);

/// The camera of that name, else the camera of that index; empty `text`: the first. Errors: not_found, naming
/// the cameras there are.
Result<Camera> find_camera(const Scene& scene, const std::string& text);

}  // namespace photond
