#include "shapes.h"

#include <cmath>

namespace photond::samples {
namespace {

Vec3 on_circle(float angle, float radius) { return {radius * std::cos(angle), 0, radius * std::sin(angle)}; }

/// Two triangles between the rows i, i+1 and the columns j, j+1 of a grid of vertices.
void add_cell(Shape& shape, std::uint32_t i, std::uint32_t j, std::uint32_t columns) {
  const std::uint32_t a = i * columns + j, b = a + 1, c = a + columns, d = c + 1;
  shape.triangles.emplace_back(a, b, d);
  shape.triangles.emplace_back(a, d, c);
}

}  // namespace

void append(Shape& whole, const Shape& part) {
  const auto offset = static_cast<std::uint32_t>(whole.positions.size());
  whole.positions.insert(whole.positions.end(), part.positions.begin(), part.positions.end());
  whole.normals.insert(whole.normals.end(), part.normals.begin(), part.normals.end());
  for (const glm::uvec3& t : part.triangles) whole.triangles.push_back(t + offset);
}

Shape quad(const Vec3& corner, const Vec3& u, const Vec3& v) {
  return {{corner, corner + u, corner + u + v, corner + v}, {}, {{0, 1, 2}, {0, 2, 3}}};
}

Shape box(const Vec3& center, const Vec3& half_size, float yaw) {
  const Vec3 x = half_size.x * Vec3(std::cos(yaw), 0, -std::sin(yaw));
  const Vec3 z = half_size.z * Vec3(std::sin(yaw), 0, std::cos(yaw));
  const Vec3 y(0, half_size.y, 0);
  Shape shape;
  const auto side = [&](const Vec3& out, const Vec3& u, const Vec3& v) {
    append(shape, quad(center + out - u - v, 2.0f * u, 2.0f * v));
  };
  side(x, y, z);
  side(-x, z, y);
  side(y, z, x);
  side(-y, x, z);
  side(z, x, y);
  side(-z, y, x);
  return shape;
}

Shape sphere(const Vec3& center, float radius, int rings, bool inward) {
  Shape shape;
  const int segments = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    const float theta = kPi * static_cast<float>(i) / static_cast<float>(rings);
    for (int j = 0; j <= segments; ++j) {
      const float phi = -2 * kPi * static_cast<float>(j % segments) / static_cast<float>(segments);
      const Vec3 normal = on_circle(phi, std::sin(theta)) + Vec3(0, std::cos(theta), 0);
      shape.positions.push_back(center + radius * normal);
      shape.normals.push_back(inward ? -normal : normal);
    }
  }
  const auto columns = static_cast<std::uint32_t>(segments + 1);
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(rings); ++i) {
    for (std::uint32_t j = 0; j + 1 < columns; ++j) {
      const std::uint32_t a = i * columns + j, b = a + 1, c = a + columns, d = c + 1;
      // Of the cells at the poles one triangle is left.
      if (i + 1 < static_cast<std::uint32_t>(rings)) shape.triangles.emplace_back(a, c, d);
      if (i > 0) shape.triangles.emplace_back(a, d, b);
    }
  }
  for (glm::uvec3& t : shape.triangles) {
    if (inward) std::swap(t.y, t.z);
  }
  return shape;
}

Shape cylinder(const Vec3& base, float lower_radius, float upper_radius, float height, int segments) {
  Shape shape;
  const Vec3 top = base + Vec3(0, height, 0);
  for (int j = 0; j < segments; ++j) {
    const float a0 = 2 * kPi * static_cast<float>(j) / static_cast<float>(segments);
    const float a1 = 2 * kPi * static_cast<float>(j + 1) / static_cast<float>(segments);
    const Vec3 p0 = base + on_circle(a0, lower_radius), p1 = base + on_circle(a1, lower_radius);
    const Vec3 q0 = top + on_circle(a0, upper_radius), q1 = top + on_circle(a1, upper_radius);
    append(shape, {{p0, q0, q1, p1}, {}, {{0, 1, 2}, {0, 2, 3}}});
    append(shape, {{base, p0, p1}, {}, {{0, 1, 2}}});
    append(shape, {{top, q1, q0}, {}, {{0, 1, 2}}});
  }
  return shape;
}

Shape torus(const Vec3& center, float radius, float tube_radius, int segments) {
  Shape shape;
  const int around = 2 * segments;
  for (int i = 0; i <= around; ++i) {
    const float phi = 2 * kPi * static_cast<float>(i % around) / static_cast<float>(around);
    const Vec3 out = on_circle(phi, 1);
    for (int j = 0; j <= segments; ++j) {
      const float theta = 2 * kPi * static_cast<float>(j % segments) / static_cast<float>(segments);
      const Vec3 normal = std::cos(theta) * out + Vec3(0, std::sin(theta), 0);
      shape.positions.push_back(center + radius * out + tube_radius * normal);
      shape.normals.push_back(normal);
    }
  }
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(around); ++i) {
    for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(segments); ++j) {
      add_cell(shape, i, j, static_cast<std::uint32_t>(segments + 1));
    }
  }
  return shape;
}

}  // namespace photond::samples
