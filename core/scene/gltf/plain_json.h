#pragma once

#include <string>

#include "core/base/result.h"
#include "core/scene/gltf/container.h"
#include "core/scene/gltf/json_scan.h"

namespace photond::gltf {

/// Whether a buffer has no data to load, only room for what EXT_meshopt_compression unpacks.
bool is_placeholder(const JsonScan& scan, std::size_t buffer, bool binary);

/// The JSON of a file with compressed data as tinygltf takes it, which knows of no such data: every buffer has a URI,
/// placeholders that of one byte; and the indices of a primitive under KHR_draco_mesh_compression, whose accessor needs
/// no buffer view, are named in that extension instead. Throws what nlohmann::json does.
std::string plain_json(const Container& container, const JsonScan& scan);

}  // namespace photond::gltf
