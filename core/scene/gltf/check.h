#pragma once

#include <tiny_gltf.h>

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/scene/gltf.h"

namespace photond::gltf {

/// Checks every reference, range and alignment of a parsed file, so that what follows may index freely:
/// asset version, buffer views, accessors, images, samplers, textures, meshes, cameras, lights, nodes (a
/// forest: one parent each, no cycle) with skins, and scenes.
Status check_model(const tinygltf::Model& model, const SceneLimits& limits);

// The parts of check_model.
Status check_buffer_views(const tinygltf::Model& model);
Status check_accessors(const tinygltf::Model& model, const SceneLimits& limits);
Status check_textures(const tinygltf::Model& model);
Status check_meshes(const tinygltf::Model& model);
Status check_cameras(const tinygltf::Model& model);
Status check_lights(const tinygltf::Model& model);
Status check_nodes(const tinygltf::Model& model);
Status check_scenes(const tinygltf::Model& model);

/// "array[index]".
std::string place(std::string_view array, std::size_t index);

/// An error unless 0 ≤ index < size; −1 passes where `optional`.
Status check_index(int index, std::size_t size, const std::string& where, bool optional = false);

}  // namespace photond::gltf
