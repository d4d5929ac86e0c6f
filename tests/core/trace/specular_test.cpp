#include "core/trace/specular.h"

#include <gtest/gtest.h>

#include <memory>

#include "core/trace/medium.h"
#include "core/trace/prepare.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

const Rgb kTint{0.9f, 0.5f, 0.7f};
const Rgb kFlux{1, 2, 3};

// Balls so coarse that shading normals often would send light to the wrong side, and blocks.
std::shared_ptr<const PreparedScene> specular_things() {
  Scene scene = test::empty_scene();
  Material glass = test::glass(1.5f);
  glass.base_color = kTint;
  for (const Material& material : {test::mirror(kTint), glass}) {
    const float x = material.metallic > 0 ? -2.0f : 2.0f;
    test::add_mesh(scene, test::sphere({x, 0, 0}, 0.8f, 6), test::add_material(scene, material));
    test::add_mesh(scene, test::box({x - 0.5f, 1, -0.5f}, {x + 0.5f, 2, 0.5f}), test::add_material(scene, material));
  }
  return test::prepared(std::move(scene));
}

struct Met {
  Ray ray;
  Hit hit;
};

// Photons that meet something, from outside and from inside.
std::vector<Met> photons(const PreparedScene& scene, std::size_t count) {
  Rng rng(3, RngPurpose::pilot, 0, 0);
  std::vector<Met> met;
  while (met.size() < count) {
    const Vec3 at{8 * rng.next() - 4, 4 * rng.next() - 1, 2 * rng.next() - 1};
    const Ray ray{at, square_to_sphere(rng.next2())};
    const Hit hit = scene.accel.intersect(ray);
    if (hit.found()) met.push_back({ray, hit});
  }
  return met;
}

std::unique_ptr<SpecularBounces> lanes_of(const PreparedScene& scene, std::span<const Met> met, std::uint32_t depth,
                                          Rng& rng) {
  auto lanes = std::make_unique<SpecularBounces>();
  for (std::uint32_t k = 0; k < met.size(); ++k) {
    lanes->set(k, scene.placed_at(met[k].hit), met[k].hit, met[k].ray.direction, kFlux, depth, rng);
  }
  return lanes;
}

TEST(Specular, IsWhatBsdfsSampleOneByOne) {
  const auto scene = specular_things();
  const std::vector<Met> met = photons(*scene, 200 * kLanes);
  Rng rng(1, RngPurpose::pilot, 0, 0);
  int reflected = 0, refracted = 0, left = 0;
  for (std::size_t first = 0; first < met.size(); first += kLanes) {
    const auto lanes = lanes_of(*scene, std::span(met).subspan(first, kLanes), 1, rng);
    for (float& roulette : lanes->random[1]) roulette = 0;   // all survive
    lanes->scatter(kLanes);
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      const auto& [ray, hit] = met[first + k];
      const SurfacePoint s = make_surface(scene->scene, ray, hit);
      const Bsdf bsdf(scene->scene, s, -ray.direction);
      left += lanes->settled[k] == 0;
      if (lanes->settled[k] == 0) continue;
      const auto sample = bsdf.sample({0, 0, lanes->random[0][k]}, kAllLobes, Transport::flux);
      ASSERT_TRUE(sample.has_value());
      EXPECT_FALSE(bsdf.flat(sample->lobe));
      reflected += !sample->transmitted;
      refracted += sample->transmitted;
      Rgb next = kFlux * sample->weight;
      next *= shading_normal_factor(s.ns, s.ng, -ray.direction, sample->wi, SpecularBounces::kMostNormalFactor);
      next *= 1 / std::min(1.0f, max_component(next) / max_component(kFlux));
      // The same formulas in another order; near grazing, where cosines are small, factors differ by more.
      constexpr float kRounding = 1e-4f;
      const float grazing = std::abs(glm::dot(sample->wi, s.ng) * glm::dot(ray.direction, s.ng));
      EXPECT_LT(glm::distance(lanes->next_direction[k], sample->wi), kRounding / std::max(grazing, 1e-3f) + kRounding);
      EXPECT_LT(glm::distance(lanes->next_flux[k], next), kRounding / std::max(grazing, 1e-3f) * glm::length(next));
      EXPECT_NEAR(lanes->squeeze[k], sample->transmitted ? compression(s) : 1, kRounding);
      EXPECT_LT(glm::distance(lanes->origin[k], spawn_ray(s, sample->wi).origin), 1e-6f);
    }
  }
  EXPECT_GT(reflected, 1000);
  EXPECT_GT(refracted, 1000);
  EXPECT_GT(left, 50);
}

// A mirror's survivors carry its colour's share of the flux on average, also of long paths, and each the power of the
// brightest channel.
TEST(Specular, RouletteKeepsTheFlux) {
  Scene built = test::empty_scene();
  test::add_mesh(built, test::parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), test::add_material(built, test::mirror(kTint)));
  const auto scene = test::prepared(std::move(built));
  const Ray ray{{0.3f, -0.2f, 1}, glm::normalize(Vec3(-0.1f, 0.4f, -1))};
  const std::vector<Met> met(kLanes, Met{ray, scene->accel.intersect(ray)});
  Rng rng(5, RngPurpose::pilot, 0, 0);
  for (const std::uint32_t depth : {1u, 1000u}) {
    test::Sample seen[3];
    for (int i = 0; i < 2000; ++i) {
      const auto lanes = lanes_of(*scene, met, depth, rng);
      lanes->scatter(kLanes);
      for (std::uint32_t k = 0; k < kLanes; ++k) {
        for (int c = 0; c < 3; ++c) seen[c].add(lanes->next_flux[k][c]);
      }
    }
    for (int c = 0; c < 3; ++c) EXPECT_TRUE(test::agrees(seen[c], kFlux[c] * kTint[c])) << "depth " << depth;
  }
}

}  // namespace
}  // namespace photond
