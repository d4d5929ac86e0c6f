#include "core/trace/few_triangles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "core/math/frame.h"
#include "core/math/warp.h"
#include "core/trace/prepare.h"
#include "core/trace/surface.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

Mesh transformed(Mesh mesh, const Affine& m) {
  for (Vec3& p : mesh.positions) p = transform_point(m, p);
  return mesh;
}

// No axis lies along an edge.
Affine turned(float scale, const Vec3& to) {
  const Frame frame(glm::normalize(Vec3(0.3f, -0.5f, 0.7f)));
  return {scale * frame.s, scale * frame.t, scale * frame.n, to};
}

// A closed room of twelve triangles.
std::shared_ptr<const PreparedScene> walls(const Affine& m) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, transformed(test::box({-1, -1, -1}, {1, 1.5f, 1.25f}, true), m),
                 test::add_material(scene, test::lambert(Rgb(0.7f))));
  return test::prepared(std::move(scene));
}

// A closed room with a block, a ball of many triangles and a blended pane.
std::shared_ptr<const PreparedScene> room() {
  Scene scene = test::empty_scene();
  const auto white = test::add_material(scene, test::lambert(Rgb(0.7f)));
  test::add_mesh(scene, test::box({-1, -1, -1}, {1, 1.5f, 1.25f}, true), white);
  test::add_mesh(scene, test::box({-0.3f, -0.2f, -0.9f}, {0.2f, 0.4f, 0.1f}), white);
  test::add_mesh(scene, test::sphere({0.5f, 0.5f, 0.3f}, 0.3f, 16), white);
  Material pane = test::lambert(Rgb(0.5f));
  pane.alpha_mode = AlphaMode::blend;
  pane.alpha = 1;
  test::add_mesh(scene, test::parallelogram({0.2f, 0.3f, 0.9f}, {0.5f, 0, 0.1f}, {0, 0.5f, 0}),
                 test::add_material(scene, pane));
  return test::prepared(std::move(scene));
}

Vec3 inside(Rng& rng) {
  const Vec3 unit{rng.next(), rng.next(), rng.next()};
  return Vec3(-0.95f) + unit * Vec3(1.9f, 2.4f, 2.1f);
}

struct Lanes {
  RayLanes rays{};
  HitLanes hits;
  std::uint8_t hidden[kLanes];
};

FewTriangles few_of(const PreparedScene& scene) {
  return FewTriangles(scene.scene, FewTriangles::choose(scene.scene));
}

TEST(FewTriangles, AreTheLargestOpaqueInstancesInPlace) {
  const auto scene = room();
  EXPECT_EQ(FewTriangles::choose(scene->scene), (std::vector<std::uint32_t>{0, 1}));
  Scene moved = scene->scene;
  moved.instances[0].moved = true;
  EXPECT_TRUE(FewTriangles::choose(moved).empty());   // what is left fills the scene
}

TEST(FewTriangles, MayHaveOthersAllAroundThatFillLittle) {
  Scene scene = test::empty_scene();
  const auto white = test::add_material(scene, test::lambert(Rgb(0.7f)));
  test::add_mesh(scene, test::box({-1, -1, -1}, {1, 1, 1}, true), white);
  for (const float x : {-0.8f, 0.8f}) test::add_mesh(scene, test::sphere({x, x, x}, 0.15f, 16), white);
  EXPECT_EQ(FewTriangles::choose(test::prepared(scene)->scene), std::vector<std::uint32_t>{0});
  test::add_mesh(scene, test::sphere({0, 0, 0}, 0.9f, 16), white);
  EXPECT_TRUE(FewTriangles::choose(test::prepared(scene)->scene).empty());
}

TEST(FewTriangles, LanesMeetWhatSingleRaysMeet) {
  const auto scene = room();
  Rng rng(1, RngPurpose::pilot, 0, 0);
  const auto lanes = std::make_unique<Lanes>();
  int met[4] = {}, differ = 0;
  for (int round = 0; round < 1000; ++round) {
    const std::uint32_t count = 1 + static_cast<std::uint32_t>(round) % kLanes;
    for (std::uint32_t k = 0; k < count; ++k) {
      lanes->rays.set(k, {inside(rng), square_to_sphere(rng.next2()), k % 4 == 3 ? rng.next() : kInfinity});
    }
    scene->accel.intersect(lanes->rays, count, Coherence::none, lanes->hits);
    scene->accel.occluded(lanes->rays, count, lanes->hidden);
    for (std::uint32_t k = 0; k < count; ++k) {
      const Hit one = scene->accel.intersect(lanes->rays.ray(k)), hit = lanes->hits[k];
      ASSERT_EQ(hit.found(), one.found());
      EXPECT_EQ(lanes->hidden[k] != 0, one.found());
      if (!one.found()) continue;
      ++met[hit.instance];
      constexpr float kRounding = 1e-4f;   // of both; grazing rays magnify it
      EXPECT_NEAR(hit.t, one.t, kRounding);
      // Rays on an edge may meet either side.
      if (hit.instance != one.instance || hit.triangle != one.triangle) {
        ++differ;
        continue;
      }
      EXPECT_NEAR(hit.u, one.u, kRounding);
      EXPECT_NEAR(hit.v, one.v, kRounding);
    }
  }
  for (const int count : met) EXPECT_GT(count, 100);
  EXPECT_LT(differ, 5);
}

// Rays towards edges, corners and diagonals, and those along them; rooms of any size, far away, too.
TEST(FewTriangles, NoRaySlipsThroughEdgesOrCorners) {
  const auto lanes = std::make_unique<Lanes>();
  Rng rng(2, RngPurpose::pilot, 0, 0);
  for (const float scale : {1e-4f, 1.0f, 1e6f}) {
    for (const Affine& m : {Affine(scale), turned(scale, Vec3(0)), turned(scale, Vec3(1e5f * scale))}) {
      const auto scene = walls(m);
      const FewTriangles few = few_of(*scene);
      const Mesh& mesh = scene->scene.meshes[0];
      const auto place = [&](const Vec3& p) { return transform_point(m, p) - scene->scene.origin; };
      for (int round = 0; round < 1000; ++round) {
        for (std::uint32_t k = 0; k < kLanes; ++k) {
          const glm::uvec3& t = mesh.triangles[rng.next_uint() % mesh.triangles.size()];
          const float along = k % 8 == 0 ? 0 : rng.next();
          const Vec3 target = glm::mix(mesh.positions[t.x], mesh.positions[t[1 + k % 2]], along);
          Vec3 origin = place(inside(rng));
          if (k % 8 == 1) origin = glm::mix(target, origin, 1e-3f);
          lanes->rays.set(k, {origin, glm::normalize(target - origin)});
        }
        few.intersect(lanes->rays, kLanes, lanes->hits);
        few.occluded(lanes->rays, kLanes, lanes->hidden);
        for (std::uint32_t k = 0; k < kLanes; ++k) {
          ASSERT_TRUE(lanes->hits[k].found()) << scale << " lane " << k;
          ASSERT_EQ(lanes->hidden[k], 1);
        }
      }
    }
  }
}

// Against planes in double precision.
TEST(FewTriangles, ErrNoMoreThanTheTree) {
  const auto lanes = std::make_unique<Lanes>();
  Rng rng(3, RngPurpose::pilot, 0, 0);
  for (const float scale : {1e-4f, 1.0f, 1e6f}) {
    const auto scene = walls(turned(scale, Vec3(0)));
    const FewTriangles few = few_of(*scene);
    const Mesh& mesh = scene->scene.meshes[0];
    double error[2] = {}, place_error[2] = {};
    for (int round = 0; round < 1000; ++round) {
      for (std::uint32_t k = 0; k < kLanes; ++k) {
        lanes->rays.set(k, {transform_point(turned(scale, Vec3(0)), inside(rng)), square_to_sphere(rng.next2())});
      }
      few.intersect(lanes->rays, kLanes, lanes->hits);
      for (std::uint32_t k = 0; k < kLanes; ++k) {
        const Ray ray = lanes->rays.ray(k);
        const Hit hits[2] = {lanes->hits[k], scene->accel.intersect(ray)};
        for (int i = 0; i < 2; ++i) {
          ASSERT_TRUE(hits[i].found());
          const glm::uvec3& t = mesh.triangles[hits[i].triangle];
          const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
          const glm::dvec3 n = glm::normalize(glm::cross(b - a, c - a)), o(ray.origin), d(ray.direction);
          const double slant = glm::dot(n, d), exact = glm::dot(n, a - o) / slant;
          const glm::dvec3 point = (1.0 - hits[i].u - hits[i].v) * a + double(hits[i].u) * b + double(hits[i].v) * c;
          error[i] += std::abs((hits[i].t - exact) * slant);
          place_error[i] += glm::distance(point, o + exact * d);
        }
      }
    }
    constexpr double kChance = 1.1;
    EXPECT_LT(error[0], kChance * error[1]) << scale;
    EXPECT_LT(place_error[0], kChance * place_error[1]) << scale;
  }
}

// Rays within walls or barely off them, of no direction, of none that is a number; triangles without area.
TEST(FewTriangles, HostileRaysAndTrianglesLeaveNoNumbersUndefined) {
  Scene degenerate = test::empty_scene();
  const auto white = test::add_material(degenerate, test::lambert(Rgb(1)));
  Mesh mesh = test::parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  mesh.positions.push_back({0, 0, 0});   // on the diagonal of the others
  mesh.normals.assign(mesh.positions.size(), Vec3(0, 0, 1));
  mesh.uv[0].resize(mesh.positions.size());
  mesh.triangles.insert(mesh.triangles.begin(), {{0, 0, 0}, {0, 1, 1}, {0, 4, 2}, {2, 4, 0}});
  test::add_mesh(degenerate, mesh, white);
  const auto scene = test::prepared(std::move(degenerate));
  const FewTriangles few = few_of(*scene);
  const auto lanes = std::make_unique<Lanes>();
  const Ray rays[] = {{{0, 0, 1}, {0, 0, -1}},        {{0.3f, -0.2f, 1}, {0, 0, -1}}, {{-2, 0, 0}, {1, 0, 0}},
                      {{-2, 0, 1e-7f}, {1, 0, 0}},    {{0, 0, 0}, {0, 0, 1}},         {{0, 0, 1}, {0, 0, 0}},
                      {{0, 0, 1}, Vec3(std::nanf(""))}, {{-1, -1, 1}, {0, 0, -1}},
                      {{0, 0, 1}, {0, 0, -1e-16f}},   {{0, 0, 1}, {0, 0, -1e16f}},    {{-2, -2, 0}, {1, 1, 0}}};
  constexpr std::uint32_t kCount = std::size(rays);
  for (std::uint32_t k = 0; k < kCount; ++k) lanes->rays.set(k, rays[k]);
  few.intersect(lanes->rays, kCount, lanes->hits);
  few.occluded(lanes->rays, kCount, lanes->hidden);
  for (std::uint32_t k = 0; k < kCount; ++k) {
    const Hit hit = lanes->hits[k];
    EXPECT_EQ(hit.found(), k <= 1 || (k >= 7 && k <= 9)) << k;
    EXPECT_EQ(lanes->hidden[k] != 0, hit.found());
    EXPECT_FALSE(std::isnan(hit.t) || std::isnan(hit.u) || std::isnan(hit.v)) << k;
    if (!hit.found()) continue;
    EXPECT_GE(hit.triangle, 4u);
    EXPECT_FLOAT_EQ(hit.t * -rays[k].direction.z, 1);
  }
}

// What a ray meets does not depend on its lane or on its neighbours, to the last bit.
TEST(FewTriangles, NeighboursDoNotMatter) {
  const auto scene = walls(turned(1, Vec3(0)));
  const FewTriangles few = few_of(*scene);
  const auto lanes = std::make_unique<Lanes>(), alone = std::make_unique<Lanes>();
  Rng rng(4, RngPurpose::pilot, 0, 0);
  for (std::uint32_t k = 0; k < kLanes; ++k) lanes->rays.set(k, {inside(rng) * 0.5f, square_to_sphere(rng.next2())});
  few.intersect(lanes->rays, kLanes, lanes->hits);
  for (std::uint32_t k = 0; k < kLanes; ++k) {
    alone->rays.set(0, lanes->rays.ray(k));
    few.intersect(alone->rays, 1, alone->hits);
    const Hit a = lanes->hits[k], b = alone->hits[0];
    EXPECT_TRUE(a.t == b.t && a.u == b.u && a.v == b.v && a.triangle == b.triangle && a.instance == b.instance);
  }
}

// In a convex room the next thing that a ray from a wall meets is another wall.
TEST(FewTriangles, SpawnedRaysDoNotMeetTheirOwnWall) {
  const auto lanes = std::make_unique<Lanes>(), next = std::make_unique<Lanes>();
  Rng rng(5, RngPurpose::pilot, 0, 0);
  for (const float scale : {1e-4f, 1.0f, 1e6f}) {
    const auto scene = walls(turned(scale, Vec3(0)));
    const FewTriangles few = few_of(*scene);
    for (int round = 0; round < 1000; ++round) {
      for (std::uint32_t k = 0; k < kLanes; ++k) {
        lanes->rays.set(k, {transform_point(turned(scale, Vec3(0)), inside(rng)), square_to_sphere(rng.next2())});
      }
      few.intersect(lanes->rays, kLanes, lanes->hits);
      Vec3 normal[kLanes];
      for (std::uint32_t k = 0; k < kLanes; ++k) {
        ASSERT_TRUE(lanes->hits[k].found());
        const SurfacePoint s = make_surface(scene->scene, lanes->rays.ray(k), lanes->hits[k]);
        normal[k] = s.ng;
        next->rays.set(k, spawn_ray(s, Frame(s.ng).to_world(square_to_cosine_hemisphere(rng.next2()))));
      }
      few.intersect(next->rays, kLanes, next->hits);
      for (std::uint32_t k = 0; k < kLanes; ++k) {
        ASSERT_TRUE(next->hits[k].found());
        const SurfacePoint s = make_surface(scene->scene, next->rays.ray(k), next->hits[k]);
        ASSERT_LT(glm::dot(s.ng, normal[k]), 0.5f) << scale;
      }
    }
  }
}

}  // namespace
}  // namespace photond
