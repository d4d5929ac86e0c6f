#include "core/photon/reach.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/scenes.h"

namespace photond {
namespace {

constexpr Vec3 kUp{0, 0, 1};

Edges edges_of(const std::vector<Mesh>& meshes, float scale = 1, const Vec3& offset = Vec3(0)) {
  Scene scene = test::empty_scene();
  const std::uint32_t white = test::add_material(scene, test::lambert(Rgb(1)));
  for (const Mesh& mesh : meshes) test::add_mesh(scene, mesh, white);
  for (Instance& instance : scene.instances) {
    instance.to_world = Affine(Vec3(scale, 0, 0), Vec3(0, scale, 0), Vec3(0, 0, scale), offset);
  }
  return Edges(scene);
}

Mesh floor_of(float side) { return test::parallelogram({0, 0, 0}, {side, 0, 0}, {0, side, 0}); }

/// The share of an Epanechnikov kernel of radius 1 on the near side of a line at distance d from its center.
double half_plane(double d) {
  // Its marginal is 8/(3π)·(1 − x²)^{3/2}.
  double share = 0.5;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i) {
    const double x = d * (i + 0.5) / kSteps;
    share += 8 / (3 * std::numbers::pi) * std::pow(1 - x * x, 1.5) * d / kSteps;
  }
  return share;
}

// Of 32 sectors with one reach each: their edges miss the true line by up to half a sector.
constexpr double kSectorError = 0.015;

TEST(Reach, IsWholeAwayFromEdges) {
  const Edges edges = edges_of({floor_of(10)});
  const Reach reach(edges, {5, 5, 0}, kUp, 1);
  EXPECT_TRUE(reach.whole());
  EXPECT_EQ(reach.coverage(1), 1);
  EXPECT_TRUE(Reach(Edges(), {5, 5, 0}, kUp, 1).whole());
}

TEST(Reach, AHalfPlaneHasItsClosedForm) {
  const Edges edges = edges_of({floor_of(10)});
  for (const float d : {0.001f, 0.1f, 0.3f, 0.5f, 0.8f, 0.95f}) {
    for (const Vec3& point : {Vec3(d, 5.03f, 0), Vec3(10 - d, 4.9f, 0), Vec3(5.2f, d, 0)}) {
      const Reach reach(edges, point, kUp, 1);
      EXPECT_FALSE(reach.whole()) << d;
      EXPECT_NEAR(reach.coverage(1), half_plane(d), kSectorError) << d;
      if (d > 0.5f) {
        EXPECT_EQ(reach.coverage(0.25f), 1) << d;
      }
    }
  }
}

TEST(Reach, AtAPlatesEdgeIsAHalfAndAtItsCornerAQuarter) {
  const Edges edges = edges_of({floor_of(10)});
  constexpr float kNext = 1e-6f;   // a point can be no nearer to an edge than rounding, or it lies on either side
  EXPECT_NEAR(Reach(edges, {kNext, 5, 0}, kUp, 1).coverage(1), 0.5, kSectorError);
  for (const Vec3& corner : {Vec3(kNext, kNext, 0), Vec3(9.999999f, kNext, 0), Vec3(9.999999f, 9.999999f, 0)}) {
    EXPECT_NEAR(Reach(edges, corner, kUp, 1).coverage(1), 0.25, kSectorError);
  }
  // Independent of the radius, as no length is given.
  EXPECT_NEAR(Reach(edges, {kNext, kNext, 0}, kUp, 1).coverage(0.01f), 0.25, kSectorError);
}

/// Which half is the surface is not known there: the kernel stays as it is, rather than nothing of it.
TEST(Reach, OnAnEdgeItselfNothingIsLost) {
  const Edges edges = edges_of({floor_of(10)});
  EXPECT_EQ(Reach(edges, {0, 5, 0}, kUp, 1).coverage(1), 1);
}

/// Near a corner, by quadrature.
TEST(Reach, NearACornerCutsBothSides) {
  const Edges edges = edges_of({floor_of(10)});
  for (const Vec2& p : {Vec2(0.2f, 0.3f), Vec2(0.05f, 0.6f), Vec2(0.7f, 0.7f)}) {
    double inside = 0, all = 0;
    constexpr int kSteps = 400;
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {
        const double x = 2 * (i + 0.5) / kSteps - 1, y = 2 * (j + 0.5) / kSteps - 1;
        const double kernel = std::max(0.0, 1 - x * x - y * y);
        all += kernel;
        if (static_cast<double>(p.x) + x > 0 && static_cast<double>(p.y) + y > 0) inside += kernel;
      }
    }
    EXPECT_NEAR(Reach(edges, {p.x, p.y, 0}, kUp, 1).coverage(1), inside / all, kSectorError);
  }
}

/// What lies beyond an edge, seen from the point, is out of reach, and nothing else is.
TEST(Reach, EndsAtTheEdge) {
  const Edges edges = edges_of({floor_of(10)});
  const Reach reach(edges, {0.3f, 5.05f, 0}, kUp, 1);
  Rng rng(1, RngPurpose::pilot, 0, 0);
  int wrong = 0, count = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 offset(2 * rng.next() - 1, 2 * rng.next() - 1, 0);
    if (glm::dot(offset, offset) >= 1) continue;
    wrong += reach.within(offset) != (offset.x > -0.3f);
    ++count;
  }
  // By those triangles between the sectors' arcs and the line, on both sides of it: some more than their sum.
  EXPECT_LT(wrong, 2 * kSectorError * count);
}

/// Eight offsets at once are told apart as one by one, but within rounding of the limit.
TEST(Reach, TellsEightAsOne) {
  const Edges edges = edges_of({floor_of(10)});
  const Reach reach(edges, {0.3f, 0.4f, 0}, kUp, 1);
  Rng rng(3, RngPurpose::pilot, 0, 0);
  int within = 0;
  for (int round = 0; round < 1000; ++round) {
    Vec3Lanes offsets{};
    for (std::uint32_t k = 0; k < 8; ++k) offsets.set(k, {2 * rng.next() - 1, 2 * rng.next() - 1, rng.next() - 0.5f});
    const std::uint32_t bits = bits8(reach.within(load8(offsets, 0)));
    for (std::uint32_t k = 0; k < 8; ++k) {
      within += bits >> k & 1;
      if (reach.within(0.9999f * offsets[k]) != reach.within(1.0001f * offsets[k])) continue;
      EXPECT_EQ((bits >> k & 1) != 0, reach.within(offsets[k])) << offsets[k].x << ' ' << offsets[k].y;
    }
  }
  EXPECT_GT(within, 2000);
  EXPECT_LT(within, 6000);
}

/// A wall that stands on the floor, thinner than the radius, open at its foot: what is behind it is out of reach.
TEST(Reach, EndsAtTheFootOfAThinWall) {
  const Edges edges = edges_of({floor_of(10), test::box({5, -1, 0}, {5.02f, 11, 3})});
  const Reach reach(edges, {4.8f, 5, 0}, kUp, 1);
  EXPECT_FALSE(reach.within(Vec3(0.5f, 0.01f, 0)));
  EXPECT_TRUE(reach.within(Vec3(-0.5f, 0.01f, 0)));
  EXPECT_NEAR(reach.coverage(1), half_plane(0.2), kSectorError);
}

TEST(Reach, EdgesAboveOrBelowAreOthers) {
  const Edges edges = edges_of({floor_of(10), test::parallelogram({4, 4, 0.5f}, {2, 0, 0}, {0, 2, 0}),
                                test::parallelogram({4, 4, -0.5f}, {2, 0, 0}, {0, 2, 0})});
  EXPECT_TRUE(Reach(edges, {5.5f, 5.5f, 0}, kUp, 1).whole());
}

TEST(Reach, DependsOnNeitherScaleNorPlace) {
  const Mesh plate = floor_of(8);
  for (const float scale : {0x1p-20f, 1.0f, 0x1p20f}) {
    for (const float shift : {0.0f, 16.0f}) {
      const Edges edges = edges_of({plate}, scale, scale * Vec3(shift, -shift, shift));
      const Vec3 point = scale * Vec3(0.25f + shift, 4.125f - shift, shift);
      EXPECT_EQ(Reach(edges, point, kUp, scale).coverage(scale * scale),
                Reach(edges_of({plate}), {0.25f, 4.125f, 0}, kUp, 1).coverage(1))
          << scale << " " << shift;
    }
  }
}

}  // namespace
}  // namespace photond
