#include "core/render/film_rays.h"

#include <gtest/gtest.h>

#include <vector>

namespace photond {
namespace {

constexpr int kWidth = 37, kHeight = 11;   // no multiples of the lanes
constexpr std::uint64_t kSeed = 5;
constexpr std::uint32_t kPass = 21;

void expect_rays_of(const Camera& camera, std::uint64_t first, std::size_t count) {
  std::vector<Ray> rays(count);
  std::vector<CameraSampler> samplers(count);
  film_rays(camera, {kWidth, kHeight, kSeed, kPass, first}, rays, samplers);
  for (std::size_t i = 0; i < count; ++i) {
    CameraSampler sampler(kSeed, kPass, first + i);
    const Vec2 jitter = sampler.next2();
    const auto x = static_cast<float>((first + i) % kWidth), y = static_cast<float>((first + i) / kWidth);
    const Ray ray = camera_ray(camera, {(x + jitter.x) / kWidth, (y + jitter.y) / kHeight}, float{kWidth} / kHeight);
    // One rounding may differ between lanes and single rays, by fused multiplication.
    EXPECT_LT(glm::distance(rays[i].origin, ray.origin), 1e-5f);
    EXPECT_LT(glm::distance(rays[i].direction, ray.direction), 1e-6f);
    EXPECT_EQ(rays[i].t_max, kInfinity);
    EXPECT_EQ(samplers[i].next2(), sampler.next2());
  }
}

TEST(FilmRays, GoThroughTheirPixels) {
  Camera camera = look_at({1, 2, 3}, {4, 0, 1}, {0, 1, 0}, 0.9f);
  expect_rays_of(camera, 0, kWidth * kHeight);
  expect_rays_of(camera, 30, 50);
  camera.orthographic = true;
  camera.ymag = 2;
  expect_rays_of(camera, 30, 50);
}

TEST(FilmRays, AreWhereGltfSaysThatACameraLooks) {
  Camera camera;
  camera.yfov = kPi / 2;
  const Ray corner = camera_ray(camera, {0, 0}, 2);
  EXPECT_LT(glm::distance(corner.direction, glm::normalize(Vec3(-2, 1, -1))), 1e-6f);
  EXPECT_LT(glm::distance(camera_ray(camera, {0.5f, 0.5f}, 2).direction, Vec3(0, 0, -1)), 1e-6f);
  camera.orthographic = true;
  camera.ymag = 3;
  const Ray lower = camera_ray(camera, {1, 1}, 2);
  EXPECT_LT(glm::distance(lower.origin, Vec3(6, -3, 0)), 1e-5f);
  EXPECT_LT(glm::distance(lower.direction, Vec3(0, 0, -1)), 1e-6f);
}

}  // namespace
}  // namespace photond
