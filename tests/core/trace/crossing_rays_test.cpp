#include "core/trace/crossing_rays.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/math/rng.h"
#include "core/math/warp.h"

namespace photond {
namespace {

// In double precision: whether a ray meets a box before its end, by how much of its length.
double crossing(const Bounds3& box, const Ray& ray) {
  double near = 0, far = ray.t_max;
  for (int c = 0; c < 3; ++c) {
    const double inverse = 1.0 / ray.direction[c];
    const double a = (double(box.min[c]) - ray.origin[c]) * inverse, b = (double(box.max[c]) - ray.origin[c]) * inverse;
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return far - near;
}

TEST(CrossingRays, AreThoseThatMayMeetTheBox) {
  const Bounds3 box{{-0.5f, 0.2f, 0}, {0.5f, 0.7f, 0}};   // flat
  Rng rng(1, RngPurpose::pilot, 0, 0);
  int crossed = 0, all = 0;
  for (std::uint32_t count = 1; count <= kLanes; ++count) {
    RayLanes rays{};
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      const Vec3 origin = 2.0f * square_to_sphere(rng.next2()), target{rng.next(), rng.next(), 0};
      rays.set(k, {origin, glm::normalize(target - origin), k % 2 == 0 ? 2 : kInfinity});
    }
    const CrossingRays crossing_rays({box, {}}, rays, rays.t_max, count);
    std::uint32_t i = 0;
    for (std::uint32_t k = 0; k < count; ++k, ++all) {
      const double length = crossing(box, rays.ray(k));
      const bool taken = i < crossing_rays.size() && crossing_rays.rays().origin[i] == rays.origin[k];
      EXPECT_TRUE(taken || length < 0);
      EXPECT_FALSE(taken && length < -1e-5);   // in doubt
      if (!taken) continue;
      EXPECT_EQ(crossing_rays.rays().direction[i], rays.direction[k]);
      EXPECT_EQ(crossing_rays.rays().t_max[i], rays.t_max[k]);
      ++i, ++crossed;
    }
    EXPECT_EQ(i, crossing_rays.size());
  }
  EXPECT_GT(crossed, 20);
  EXPECT_LT(crossed, all - 20);
}

TEST(CrossingRays, MayGoAlongAnAxisOrBeginInside) {
  const Bounds3 box{{0, 0, 0}, {1, 1, 1}};
  RayLanes rays{};
  rays.set(0, {{-1, 0, 0.5f}, {1, 0, 0}});
  rays.set(1, {{-1, 0.999f, 0.5f}, {1, -0.0f, 0}});
  rays.set(2, {{-1, 1.001f, 0.5f}, {1, -0.0f, 0}});
  rays.set(3, {{0.5f, 0.5f, 0.5f}, {0, 0, 1}, 1e-6f});
  rays.set(4, {{2, 0.5f, 0.5f}, {1, 0, 0}});
  const CrossingRays crossing_rays({box, {}}, rays, rays.t_max, 5);
  ASSERT_EQ(crossing_rays.size(), 3u);
  EXPECT_EQ(crossing_rays.rays().t_max[2], 1e-6f);
  EXPECT_EQ(CrossingRays({}, rays, rays.t_max, 5).size(), 0u);
}

TEST(CrossingRays, CrossOneOfThePartsWhereThereAreAny) {
  const Cover cover{{{0, 0, 0}, {3, 1, 1}}, {{{0, 0, 0}, {1, 1, 1}}, {{2, 0, 0}, {3, 1, 1}}}};
  RayLanes rays{};
  for (std::uint32_t k = 0; k < kLanes; ++k) {
    rays.set(k, {{0.5f + static_cast<float>(k % 3), 0.5f, -1}, {0, 0, 1}, k < 3 ? 0.5f : kInfinity});
  }
  const CrossingRays crossing_rays(cover, rays, rays.t_max, kLanes);
  ASSERT_EQ(crossing_rays.size(), 19u);   // of 10 or 11 each; three end before they are there
  for (std::uint32_t i = 0; i < crossing_rays.size(); ++i) EXPECT_NE(crossing_rays.rays().origin[i].x, 1.5f);
}

TEST(CrossingRays, PutWhatTheyMeetWhereTheyWere) {
  RayLanes rays{};
  for (std::uint32_t k = 0; k < kLanes; ++k) rays.set(k, {{k % 3 == 0 ? 0 : 5, 0, -1}, {0, 0, 1}});
  const CrossingRays crossing_rays({{Vec3(-0.5f), Vec3(0.5f)}, {}}, rays, rays.t_max, kLanes);
  ASSERT_EQ(crossing_rays.size(), 11u);
  HitLanes met, hits;
  std::uint8_t met_any[kLanes], hidden[kLanes] = {};
  for (std::uint32_t k = 0; k < kLanes; ++k) {
    met.set(k, {0.5f, 0.1f, 0.2f, k, k % 2 == 0 ? 7 : Hit::kNone});
    hits.set(k, {});
    met_any[k] = k % 2 == 0;
  }
  crossing_rays.put(met, hits);
  crossing_rays.put(met_any, hidden);
  for (std::uint32_t k = 0; k < kLanes; ++k) {
    EXPECT_EQ(hits[k].found(), k % 6 == 0);
    EXPECT_EQ(hidden[k] != 0, k % 6 == 0);
    EXPECT_EQ(hits[k].triangle, hits[k].found() ? k / 3 : 0);
  }
}

}  // namespace
}  // namespace photond
