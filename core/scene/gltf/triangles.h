#pragma once

#include <tiny_gltf.h>

#include <cstddef>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/scene/scene.h"

namespace photond::gltf {

/// The triangles of a list, strip or fan, indexed or not. Errors: an index beyond `vertices`.
Result<std::vector<glm::uvec3>> read_triangles(const tinygltf::Model& model,
                                               const tinygltf::Primitive& primitive, std::size_t vertices,
                                               const std::string& where);

/// Removes triangles without a usable area and returns how many.
std::size_t drop_degenerate(Mesh& mesh);

/// Makes normals unit; those of length 0 become the mean of the adjacent faces' normals.
void repair_normals(Mesh& mesh);

/// Makes tangents unit with handedness ±1; where that is impossible removes all and returns false.
bool normalize_tangents(Mesh& mesh);

}  // namespace photond::gltf
