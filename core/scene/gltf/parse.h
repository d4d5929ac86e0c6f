#pragma once

#include <tiny_gltf.h>

#include <span>

#include "core/base/result.h"
#include "core/scene/gltf.h"
#include "core/scene/gltf/container.h"

namespace photond::gltf {

/// A parsed file whose references are not yet checked.
struct Parsed {
  tinygltf::Model model;
  bool binary = false;
};

/// Scans the JSON, refuses what needs unknown extensions, and runs tinygltf with callbacks that only reach
/// `resources`. Buffers are loaded, and compressed data is made ordinary; images are left encoded: `image.image` holds
/// the file of a data URI, all others keep `uri` or `bufferView`.
Result<Parsed> parse_model(std::span<const std::byte> bytes, const ResourceReader& resources,
                           const SceneLimits& limits);

}  // namespace photond::gltf
