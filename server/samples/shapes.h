#pragma once

#include <vector>

#include "core/math/types.h"

namespace photond::samples {

/// Triangles, counter-clockwise seen from their front. Normals are empty for flat shapes.
struct Shape {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;
  std::vector<glm::uvec3> triangles;
};

/// Adds `part` to `whole`; both flat or both with normals.
void append(Shape& whole, const Shape& part);

/// The parallelogram from `corner` along `u` and `v`; its front is the side of u × v.
Shape quad(const Vec3& corner, const Vec3& u, const Vec3& v);

/// A closed box around `center`, turned by `yaw` radians about the y axis.
Shape box(const Vec3& center, const Vec3& half_size, float yaw = 0);

/// A smooth sphere of `rings` × 2·`rings` faces; `inward` turns its front to the centre.
Shape sphere(const Vec3& center, float radius, int rings, bool inward = false);

/// A closed upright cylinder or truncated cone standing on `base`, flat.
Shape cylinder(const Vec3& base, float lower_radius, float upper_radius, float height, int segments);

/// A smooth lying torus.
Shape torus(const Vec3& center, float radius, float tube_radius, int segments);

}  // namespace photond::samples
