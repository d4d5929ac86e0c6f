#pragma once

#include <memory>

#include "core/base/parallel.h"
#include "core/scene/scene.h"
#include "core/trace/prepare.h"

namespace photond::test {

/// A Lambert material without specular layer.
Material lambert(const Rgb& albedo);
/// A single-sided Lambertian emitter.
Material emitter(const Rgb& radiance);
Material mirror(const Rgb& reflectance);
/// Smooth glass of a solid.
Material glass(float ior);

/// Starts a scene with no surfaces; a camera is added so that it is complete.
Scene empty_scene();
/// Adds a material and returns its index.
std::uint32_t add_material(Scene& scene, const Material& material);
/// Adds a mesh with one instance at the identity and returns the mesh's index.
std::uint32_t add_mesh(Scene& scene, Mesh mesh, std::uint32_t material);

/// The parallelogram origin + [0,1]·a + [0,1]·b, front towards a × b, uv along a and b.
Mesh parallelogram(const Vec3& origin, const Vec3& a, const Vec3& b);
/// Axis-aligned box; its faces look outwards, or inwards.
Mesh box(const Vec3& min, const Vec3& max, bool inwards = false);
/// A regular polygon around `center`, front towards `normal`.
Mesh disk(const Vec3& center, const Vec3& normal, float radius, int segments = 256);
/// A latitude-longitude sphere with smooth normals pointing outwards.
Mesh sphere(const Vec3& center, float radius, int rings = 32);
/// The mesh without its normals: every facet is flat.
Mesh faceted(Mesh mesh);
/// The mesh turned inside out.
Mesh inside_out(Mesh mesh);

void add_point_light(Scene& scene, const Vec3& position, const Rgb& intensity);
PunctualLight spot_light(const Vec3& position, const Vec3& direction, float cos_inner, float cos_outer, float intensity);

/// Prepares on the calling thread; the scene must be valid.
std::shared_ptr<const PreparedScene> prepared(Scene scene);

/// An open room with every kind of material and light.
std::shared_ptr<const PreparedScene> busy_room();

/// Workers for tests that need several threads.
const Workers& workers();

}  // namespace photond::test
