#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/scene/gltf/json_scan.h"

namespace photond::gltf {

/// Bytes that decompression may still take.
struct DecompressionBudget {
  std::uint64_t bytes;

  /// Takes `taken` bytes, or is an error.
  Status take(std::uint64_t taken, const std::string& where);
};

/// Unpacks the buffer views under EXT_meshopt_compression: each gets a buffer of its own, and is an ordinary one then.
/// Checks the references of those views. `declared`: the buffers as the file has them; placeholders hold no data.
Status decompress_views(tinygltf::Model& model, const std::vector<BufferDeclaration>& declared,
                        DecompressionBudget& budget);

/// Unpacks the primitives under KHR_draco_mesh_compression, also those with ordinary data beside it: they get accessors
/// of their own, whose data is ordinary, and are lists of triangles then. What is not compressed must have been checked.
Status decompress_primitives(tinygltf::Model& model, DecompressionBudget& budget);

/// An ErrorCode::limit_exceeded.
Error too_much_compressed_data(const std::string& where);

/// Adds a buffer of these bytes and a buffer view of it; returns the view's index.
int add_view(tinygltf::Model& model, std::vector<unsigned char> bytes, std::size_t stride);

}  // namespace photond::gltf
