#pragma once

#include <tiny_gltf.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace photond::gltf {

/// Bytes of one component of a glTF type; 0 where glTF has no such type.
std::size_t component_size(int component_type);
/// Number of components of an element as they are listed (a MAT2 has 4).
std::size_t component_count(int type);
/// Bytes from the first to the last component of an element, matrix columns padded to 4 bytes.
std::size_t element_size(const tinygltf::Accessor& accessor);

/// All elements of a checked accessor as floats, `width` values each: normalized integers mapped to [0,1] or
/// [−1,1], missing components 0 (and 1 for the fourth), sparse values applied. Errors: sparse indices that do
/// not increase or are out of range; values that are not finite or beyond ±`max_magnitude`.
Result<std::vector<float>> read_floats(const tinygltf::Model& model, int accessor, std::size_t width,
                                       float max_magnitude);

/// All elements of a checked scalar accessor of unsigned type.
Result<std::vector<std::uint32_t>> read_indices(const tinygltf::Model& model, int accessor);

}  // namespace photond::gltf
