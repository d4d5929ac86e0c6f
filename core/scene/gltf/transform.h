#pragma once

#include <tiny_gltf.h>

#include <glm/mat4x4.hpp>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/math/types.h"

namespace photond::gltf {

/// A node's matrix, or translation · rotation · scale. Errors: a rotation of length 0, a matrix whose last row
/// is not (0, 0, 0, 1).
Result<glm::dmat4> local_transform(const tinygltf::Node& node, const std::string& where);

/// translation · rotation (x, y, z, w; normalised) · scale.
glm::dmat4 compose(const glm::dvec3& translation, const glm::dvec4& rotation, const glm::dvec3& scale);

/// The upper three rows as floats. Errors: values that are not finite or absurdly large.
Result<Affine> to_affine(const glm::dmat4& matrix, const std::string& where);

/// A rigid, right-handed frame with the z axis and, as far as possible, the y axis of `matrix`; nothing where that leaves
/// no direction. Errors: as to_affine's.
Result<std::optional<Affine>> to_frame(const glm::dmat4& matrix, const std::string& where);

/// Where `matrix` flattens space onto a plane: one that leaves a millionth of its size across. Otherwise of no use.
glm::dmat4 thickened(const glm::dmat4& matrix);

/// Whether the linear part maps space onto less than space.
bool is_singular(const glm::dmat4& matrix);

}  // namespace photond::gltf
