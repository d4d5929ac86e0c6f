#include "core/scene/gltf/transform.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>

#include "core/scene/gltf/build.h"

namespace photond::gltf {
namespace {

glm::dvec3 vec3(const std::vector<double>& values, const glm::dvec3& otherwise) {
  return values.size() == 3 ? glm::dvec3(values[0], values[1], values[2]) : otherwise;
}

/// The longest of the cross products of columns.
glm::dvec3 longest_cross(const glm::dmat3& m) {
  glm::dvec3 longest = glm::cross(m[0], m[1]);
  for (const glm::dvec3& cross : {glm::cross(m[1], m[2]), glm::cross(m[2], m[0])}) {
    if (glm::dot(cross, cross) > glm::dot(longest, longest)) longest = cross;
  }
  return longest;
}

}  // namespace

glm::dmat4 compose(const glm::dvec3& translation, const glm::dvec4& rotation, const glm::dvec3& scale) {
  const glm::dvec4 q = rotation / glm::length(rotation);
  const double x = q.x, y = q.y, z = q.z, w = q.w;
  glm::dmat4 m(1);
  m[0] = scale.x * glm::dvec4(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0);
  m[1] = scale.y * glm::dvec4(2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0);
  m[2] = scale.z * glm::dvec4(2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0);
  m[3] = glm::dvec4(translation, 1);
  return m;
}

Result<glm::dmat4> local_transform(const tinygltf::Node& node, const std::string& where) {
  if (node.matrix.size() == 16) {
    glm::dmat4 m;
    for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = node.matrix[static_cast<std::size_t>(i)];
    // What a product of matrices in floats leaves there is no perspective.
    constexpr double kRounding = 1e-5;
    const glm::dvec4 last_row(m[0][3], m[1][3], m[2][3], m[3][3] - 1);
    if (!(glm::length(last_row) <= kRounding)) {
      return invalid_input("the last row of the matrix must be 0 0 0 1", where + ".matrix");
    }
    m[0][3] = m[1][3] = m[2][3] = 0, m[3][3] = 1;
    return m;
  }
  glm::dvec4 rotation(0, 0, 0, 1);
  if (node.rotation.size() == 4) {
    rotation = {node.rotation[0], node.rotation[1], node.rotation[2], node.rotation[3]};
    const double length = glm::length(rotation);
    if (!(length > 1e-6 && length < 1e6)) {
      return invalid_input("rotation is not a unit quaternion", where + ".rotation");
    }
  }
  return compose(vec3(node.translation, glm::dvec3(0)), rotation, vec3(node.scale, glm::dvec3(1)));
}

Result<Affine> to_affine(const glm::dmat4& matrix, const std::string& where) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      if (!(std::abs(matrix[column][row]) <= kMaxMagnitude)) {
        return invalid_input("transform is not finite or absurdly large", where);
      }
    }
  }
  return Affine(matrix);
}

Result<std::optional<Affine>> to_frame(const glm::dmat4& matrix, const std::string& where) {
  if (Result<Affine> bounded = to_affine(matrix, where); !bounded) return bounded.error();
  const glm::dvec3 z(matrix[2]), y(matrix[1]);
  const glm::dvec3 x = glm::cross(y, z);
  if (!(glm::length(x) > 1e-12 * glm::length(y) * glm::length(z))) return std::optional<Affine>();
  const glm::dvec3 forward = glm::normalize(z), right = glm::normalize(x);
  return std::optional<Affine>(
      {Vec3(right), Vec3(glm::cross(forward, right)), Vec3(forward), Vec3(glm::dvec3(matrix[3]))});
}

glm::dmat4 thickened(const glm::dmat4& matrix) {
  constexpr double kThickness = 1e-6;
  const glm::dmat3 m(matrix);
  // Across the plane that everything lands on, and along what lands nowhere.
  const glm::dvec3 across = longest_cross(m), lost = longest_cross(glm::transpose(m));
  const double size = std::max({glm::length(m[0]), glm::length(m[1]), glm::length(m[2])});
  if (!(glm::length(across) > 1e-12 * size * size) || !(glm::length(lost) > 0)) return matrix;
  glm::dmat3 filled = m + glm::outerProduct(kThickness * size * glm::normalize(across), glm::normalize(lost));
  if (glm::determinant(filled) < 0) filled = 2.0 * m - filled;   // hands remain what they are
  glm::dmat4 out(filled);
  out[3] = matrix[3];
  return out;
}

bool is_singular(const glm::dmat4& matrix) {
  const glm::dmat3 m(matrix);
  const double scale = glm::length(m[0]) * glm::length(m[1]) * glm::length(m[2]);
  return !(std::abs(glm::determinant(m)) > 1e-12 * scale) || scale < 1e-36;
}

}  // namespace photond::gltf
