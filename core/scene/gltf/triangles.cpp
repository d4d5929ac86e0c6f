#include "core/scene/gltf/triangles.h"

#include <algorithm>

#include "core/scene/gltf/accessor.h"

namespace photond::gltf {
namespace {

glm::dvec3 cross_product(const Mesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
  return glm::cross(b - a, c - a);
}

bool is_degenerate(const Mesh& mesh, const glm::uvec3& t) {
  if (t.x == t.y || t.y == t.z || t.z == t.x) return true;
  const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
  const double longest_sq = std::max({glm::dot(b - a, b - a), glm::dot(c - b, c - b), glm::dot(a - c, a - c)});
  // Height below 1e-10 of the longest edge: less than the rounding of float coordinates.
  return !(glm::length(cross_product(mesh, t)) > 1e-10 * longest_sq) || longest_sq < 1e-36;
}

}  // namespace

Result<std::vector<glm::uvec3>> read_triangles(const tinygltf::Model& model,
                                               const tinygltf::Primitive& primitive, std::size_t vertices,
                                               const std::string& where) {
  std::vector<std::uint32_t> corners;
  if (primitive.indices >= 0) {
    Result<std::vector<std::uint32_t>> indices = read_indices(model, primitive.indices);
    if (!indices) return indices.error();
    corners = std::move(*indices);
    for (std::uint32_t corner : corners) {
      if (corner >= vertices) return invalid_input("index refers to a missing vertex", where + ".indices");
    }
  }
  const std::size_t count = primitive.indices >= 0 ? corners.size() : vertices;
  const auto corner = [&](std::size_t i) {
    return primitive.indices >= 0 ? corners[i] : static_cast<std::uint32_t>(i);
  };
  std::vector<glm::uvec3> out;
  if (primitive.mode == TINYGLTF_MODE_TRIANGLES) {
    out.reserve(count / 3);
    for (std::size_t i = 0; i + 2 < count; i += 3) out.emplace_back(corner(i), corner(i + 1), corner(i + 2));
    return out;
  }
  const bool fan = primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN;
  for (std::size_t i = 0; i + 2 < count; ++i) {
    // [glTF 2.0, 3.7.2.1] p_i = {v_i, v_(i+1+i%2), v_(i+2-i%2)} and p_i = {v_(i+1), v_(i+2), v_0}
    if (fan) {
      out.emplace_back(corner(i + 1), corner(i + 2), corner(0));
    } else {
      out.emplace_back(corner(i), corner(i + 1 + i % 2), corner(i + 2 - i % 2));
    }
  }
  return out;
}

std::size_t drop_degenerate(Mesh& mesh) {
  return std::erase_if(mesh.triangles, [&](const glm::uvec3& t) { return is_degenerate(mesh, t); });
}

void repair_normals(Mesh& mesh) {
  if (mesh.normals.empty()) return;
  const auto usable = [](const Vec3& n) { return glm::dot(n, n) > 1e-12f; };
  std::vector<glm::dvec3> faces;
  if (!std::all_of(mesh.normals.begin(), mesh.normals.end(), usable)) {
    faces.resize(mesh.positions.size(), glm::dvec3(0));
    for (const glm::uvec3& t : mesh.triangles) {
      const glm::dvec3 normal = glm::normalize(cross_product(mesh, t));
      faces[t.x] += normal, faces[t.y] += normal, faces[t.z] += normal;
    }
  }
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    if (usable(mesh.normals[i])) {
      mesh.normals[i] = Vec3(glm::normalize(glm::dvec3(mesh.normals[i])));
    } else {
      const bool known = glm::dot(faces[i], faces[i]) > 1e-12;
      mesh.normals[i] = known ? Vec3(glm::normalize(faces[i])) : Vec3(0, 0, 1);
    }
  }
}

bool normalize_tangents(Mesh& mesh) {
  for (Vec4& tangent : mesh.tangents) {
    const glm::dvec3 direction(tangent);
    if (!(glm::dot(direction, direction) > 1e-12)) {
      mesh.tangents.clear();
      return false;
    }
    tangent = Vec4(Vec3(glm::normalize(direction)), tangent.w < 0 ? -1.0f : 1.0f);
  }
  return true;
}

}  // namespace photond::gltf
