#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/scene/scene.h"

namespace photond {

/// What a file may ask for before it is refused with ErrorCode::limit_exceeded.
struct SceneLimits {
  std::uint64_t max_triangles = 50'000'000;       ///< all instances of a mesh count once
  std::uint64_t max_placed_triangles = 50'000'000;   ///< of each instance anew: edges, casters and lamps are placed
  std::uint64_t max_emitters = 8'000'000;         ///< triangles that emit light, of each instance anew
  std::uint64_t max_vertices = 50'000'000;        ///< of each morph target that is added in anew; four per joint
  std::uint64_t max_instances = 1'000'000;
  std::uint64_t max_nodes = 1'000'000;
  std::uint64_t max_texture_pixels = 256'000'000; ///< all images together
  int max_image_side = 16'384;
  std::uint64_t max_decompressed_bytes = 1'000'000'000;  ///< of meshes and buffer views, with the data itself
  int max_decompression_seconds = 10;             ///< of one core, for all meshes compressed by Draco
  std::uint64_t max_materials = 100'000;          ///< each takes about 4 kB while the file is read
  std::uint64_t max_json_objects = 3'000'000;     ///< of all kinds, and attributes: each about 1 kB
  int max_json_depth = 128;
};

/// Returns the bytes of a resource that a .gltf names by relative URI (already percent-decoded and free of
/// `..`, schemes and absolute paths). The caller decides what it may read.
using ResourceReader = std::function<Result<std::vector<std::byte>>(const std::string& path)>;

/// A reader for files that stand alone (an uploaded GLB): every external resource is an error.
ResourceReader no_resources();

/// Parses and validates a glTF 2.0 asset, GLB or JSON told apart by its first bytes. Of the result every index
/// is in range, every float finite, and there is at least one camera and one source of light (defaults are
/// added with a warning). Degenerate triangles are dropped and counted in a warning. Never reads a file itself.
/// Errors carry a JSON-like place ("accessors[3]", "meshes[0].primitives[1].indices").
Result<Scene> read_gltf(std::span<const std::byte> bytes, const ResourceReader& resources,
                        const SceneLimits& limits = {});

}  // namespace photond
