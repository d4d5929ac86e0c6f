#include "core/photon/edges.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/scenes.h"

namespace photond {
namespace {

Scene scene_of(Mesh mesh, const Material& material = test::lambert(Rgb(0.5f))) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, std::move(mesh), test::add_material(scene, material));
  return scene;
}

std::size_t count(Mesh mesh) { return Edges(scene_of(std::move(mesh))).size(); }

/// The mesh with vertices of their own for each triangle.
Mesh split(const Mesh& mesh) {
  Mesh result;
  for (const glm::uvec3& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(result.positions.size());
    for (int k = 0; k < 3; ++k) result.positions.push_back(mesh.positions[t[k]]);
    result.triangles.emplace_back(first, first + 1, first + 2);
  }
  return result;
}

TEST(Edges, AreWhereSurfacesEndOrBend) {
  EXPECT_EQ(Edges().size(), 0u);
  EXPECT_EQ(count(test::box({-1, -1, -1}, {1, 1, 1})), 12u);
  EXPECT_EQ(count(test::box({-1, -1, -1}, {1, 1, 1}, true)), 12u);
  EXPECT_EQ(count(test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 2, 0})), 4u) << "but for the diagonal";
  EXPECT_EQ(count(test::disk({0, 0, 0}, {0, 0, 1}, 1, 64)), 64u);
}

TEST(Edges, AClosedSmoothBodyHasNone) {
  // Around the equator the last vertices must be the first ones, which the rounding of sin 2π makes another place.
  Mesh ball = test::sphere({0, 0, 0}, 1, 16);
  for (std::size_t i = 0; i < ball.positions.size(); i += 33) ball.positions[i + 32] = ball.positions[i];
  for (std::size_t i = 0; i < 33; ++i) ball.positions[i] = {0, 1, 0};
  for (std::size_t i = ball.positions.size() - 33; i < ball.positions.size(); ++i) ball.positions[i] = {0, -1, 0};
  EXPECT_EQ(count(ball), 0u);
  EXPECT_EQ(count(test::inside_out(ball)), 0u);
}

TEST(Edges, SplitVerticesAreOne) {
  EXPECT_EQ(count(split(test::box({-1, -1, -1}, {1, 1, 1}))), 12u);
  EXPECT_EQ(count(split(test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}))), 4u);
}

/// Two flat triangles that turn by less than 60° have a common surface, beyond that they do not.
TEST(Edges, BendBySixtyDegrees) {
  const auto fold = [](float degrees) {
    const float a = degrees * kPi / 180;
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {std::cos(a), 0, std::sin(a)}};
    mesh.triangles = {{0, 1, 2}, {1, 0, 3}};
    return mesh;
  };
  EXPECT_EQ(count(fold(0)), 4u);
  EXPECT_EQ(count(fold(59)), 4u);
  EXPECT_EQ(count(fold(61)), 5u);
  EXPECT_EQ(count(fold(-61)), 5u);
}

TEST(Edges, ThreeTrianglesAtOneSideMakeAnEdge) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {1, 0, 0}, {1, 0, 0.1f}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {1, 0, 4}};
  EXPECT_EQ(count(mesh), 7u);
}

TEST(Edges, TrianglesWithoutAreaHaveNoSides) {
  Mesh mesh = test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.triangles.emplace_back(0, 1, 1);
  EXPECT_EQ(count(mesh), 4u);
}

TEST(Edges, GlassHasNone) {
  EXPECT_EQ(Edges(scene_of(test::box({-1, -1, -1}, {1, 1, 1}), test::glass(1.5f))).size(), 0u);
}

/// Placements that mirror, scale by very different factors, and repeat a mesh.
TEST(Edges, FollowTheirInstances) {
  Scene scene = scene_of(test::box({-1, -1, -1}, {1, 1, 1}));
  scene.instances[0].to_world = Affine(Vec3(-3, 0, 0), Vec3(0, 1e-3f, 0), Vec3(0, 0, 2), Vec3(10, 0, 0));
  scene.instances.push_back({0, Affine(Vec3(0, 1, 0), Vec3(-1, 0, 0), Vec3(0, 0, 1), Vec3(0, 0, 50))});
  const Edges edges(scene);
  ASSERT_EQ(edges.size(), 24u);
  std::size_t first = 0, second = 0;
  edges.near({10, 0, 0}, 4, [&](const Edges::Segment& s) {
    for (const Vec3& p : {s.a, s.b}) {
      EXPECT_EQ(glm::abs(p - Vec3(10, 0, 0)), Vec3(3, 1e-3f, 2));
    }
    ++first;
  });
  edges.near({0, 0, 50}, 4, [&](const Edges::Segment& s) {
    for (const Vec3& p : {s.a, s.b}) EXPECT_EQ(glm::abs(p - Vec3(0, 0, 50)), Vec3(1));
    ++second;
  });
  EXPECT_EQ(first, 12u);
  EXPECT_EQ(second, 12u);
}

/// Every segment that comes nearer than the radius is visited, once, and none whose box is farther, but for rounding.
TEST(Edges, NearFindsWhatBruteForceFinds) {
  Rng rng(5, RngPurpose::pilot, 0, 0);
  Scene scene = test::empty_scene();
  const std::uint32_t white = test::add_material(scene, test::lambert(Rgb(1)));
  for (int i = 0; i < 200; ++i) {
    const Vec3 at(rng.next(), rng.next(), rng.next());
    test::add_mesh(scene, test::parallelogram(at, {0.1f * rng.next(), 0, 0.01f}, {0, 0.1f * rng.next(), 0}), white);
  }
  const Edges edges(scene);
  ASSERT_EQ(edges.size(), 800u);
  std::vector<Edges::Segment> all;
  edges.near({0, 0, 0}, 10, [&](const Edges::Segment& s) { all.push_back(s); });
  ASSERT_EQ(all.size(), 800u);
  const auto distance = [](const Edges::Segment& s, const Vec3& p) {
    const Vec3 along = s.b - s.a;
    const float t = std::clamp(glm::dot(p - s.a, along) / glm::dot(along, along), 0.0f, 1.0f);
    return glm::distance(p, s.a + t * along);
  };
  for (int q = 0; q < 300; ++q) {
    const Vec3 center(rng.next(), rng.next(), rng.next());
    const float radius = 0.3f * rng.next() * rng.next();
    std::multiset<std::pair<float, float>> found;   // by the ends' x: all differ
    edges.near(center, radius, [&](const Edges::Segment& s) { found.insert({s.a.x + s.a.y, s.b.x + s.b.z}); });
    for (const Edges::Segment& s : all) {
      const std::size_t times = found.count({s.a.x + s.a.y, s.b.x + s.b.z});
      ASSERT_LE(times, 1u);
      if (distance(s, center) < radius) {
        ASSERT_EQ(times, 1u);
      }
      const Vec3 nearest = glm::clamp(center, glm::min(s.a, s.b), glm::max(s.a, s.b));
      if (glm::distance(nearest, center) > 1.0001f * radius) {
        ASSERT_EQ(times, 0u);
      }
    }
  }
}

}  // namespace
}  // namespace photond
