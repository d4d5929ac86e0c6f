#include "core/render/path_lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include "core/render/radiance.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

// A room with every kind of light and of Shading. White vertex colours change nothing but that lanes do without them.
std::shared_ptr<const PreparedScene> room(bool in_lanes) {
  Scene scene = test::empty_scene();
  const auto add = [&](Mesh mesh, const Material& material) {
    if (!in_lanes) mesh.colors.assign(mesh.positions.size(), Vec4(1));
    test::add_mesh(scene, std::move(mesh), test::add_material(scene, material));
  };
  add(test::parallelogram({-1, -1, -1}, {2, 0, 0}, {0, 2, 0}), test::lambert({0.8f, 0.6f, 0.4f}));
  add(test::parallelogram({-1, -1, -1}, {0, 2, 0}, {0, 0, 2}), test::lambert({0.3f, 0.9f, 0.8f}));
  add(test::box({-0.2f, -0.2f, -1}, {0.3f, 0.4f, -0.3f}), test::lambert(Rgb(0.7f)));
  add(test::sphere({-0.6f, -0.6f, -0.7f}, 0.3f, 8), test::lambert({0.9f, 0.5f, 0.6f}));
  add(test::sphere({0.7f, -0.5f, -0.8f}, 0.2f, 8), test::mirror({0.9f, 0.8f, 0.7f}));
  Material glass = test::glass(1.5f);
  glass.base_color = {0.9f, 1, 0.8f};
  add(test::sphere({0.1f, -0.6f, -0.8f}, 0.2f, 8), glass);
  add(test::box({0.4f, 0.5f, -1}, {0.7f, 0.8f, -0.4f}), glass);
  Material lamp = test::emitter({3, 2, 1});
  add(test::parallelogram({0.2f, 0.2f, 0.6f}, {0, 0.4f, 0}, {0.4f, 0, 0}), lamp);
  lamp.double_sided = true;
  lamp.base_color = Rgb(0.5f);   // shines and reflects
  add(test::parallelogram({-0.6f, -0.6f, 0.2f}, {0, 0.4f, 0.1f}, {0.4f, 0, 0}), lamp);
  test::add_point_light(scene, {0.5f, -0.5f, 0.5f}, Rgb(0.2f));
  scene.environment.radiance = Rgb(0.1f);
  return test::prepared(std::move(scene));
}

std::array<test::Sample, 3> look(const PreparedScene& scene, const Ray& ray) {
  constexpr std::uint32_t kPasses = 20'000;
  std::array<test::Sample, 3> seen;
  const std::vector<Ray> rays(kStratifiedPasses, ray);
  for (std::uint32_t block = 0; block < kPasses / kStratifiedPasses; ++block) {
    std::vector<CameraSampler> samplers;
    for (std::uint32_t i = 0; i < kStratifiedPasses; ++i) samplers.emplace_back(1, block * kStratifiedPasses + i, 7);
    std::vector<RadianceSample> samples(kStratifiedPasses);
    estimate_incoming(scene, {}, rays, samplers, samples);
    Rgb mean(0);
    for (const RadianceSample& sample : samples) mean += sample.radiance / static_cast<float>(kStratifiedPasses);
    for (int c = 0; c < 3; ++c) seen[static_cast<std::size_t>(c)].add(mean[c]);
  }
  return seen;
}

TEST(PathLanes, AreWhatSinglePathsAre) {
  const auto lanes = room(true), single = room(false);
  const auto has = [](const PreparedScene& scene, Shading shading) {
    return std::ranges::any_of(scene.placed, [&](const PlacedMesh& mesh) { return mesh.shading == shading; });
  };
  for (const Shading shading : {Shading::diffuse, Shading::mirror, Shading::glass}) {
    EXPECT_TRUE(has(*lanes, shading));
    EXPECT_FALSE(has(*single, shading));
  }
  constexpr double kRounding = 1e-6;   // all that is left where mirrors show a sky of one colour
  const Vec3 eye{0.8f, -1.5f, 0.1f};
  const Vec3 floor{0.6f, 0.2f, -1}, wall{-1, 0, 0}, block{0, -0.2f, -0.6f}, lamp{-0.4f, -0.4f, 0.2f};
  const Vec3 smooth{-0.55f, -0.85f, -0.6f}, mirror{0.7f, -0.66f, -0.9f};
  const Vec3 ball{0.12f, -0.7f, -0.75f}, cube{0.5f, 0.5f, -0.6f};
  for (const Vec3& target : {floor, wall, block, lamp, smooth, mirror, ball, cube}) {
    const Ray ray{eye, glm::normalize(target - eye)};
    const auto a = look(*lanes, ray), b = look(*single, ray);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_GT(a[c].mean, 0);
      const double error = std::hypot(a[c].standard_error(), b[c].standard_error());
      EXPECT_LT(std::abs(a[c].mean - b[c].mean), test::kSigmas * error + kRounding) << target.x << " channel " << c;
    }
  }
}

TEST(SamplerLanes, ReturnWhatTheirSamplersWould) {
  SamplerLanes lanes;
  std::array<CameraSampler, kLanes> samplers;
  for (std::uint32_t k = 0; k < kLanes; ++k) {
    samplers[k] = CameraSampler(3, k % 20, 100 + k);
    for (std::uint32_t i = 0; i < k % 3; ++i) (void)samplers[k].next2();
    CameraSampler ahead = samplers[k];
    lanes.set(k, ahead, 2);
    CameraSampler same = samplers[k];
    (void)same.next4();
    EXPECT_EQ(ahead.next2(), same.next2());
  }
  for (int pair = 0; pair < 2; ++pair) {
    float x[kLanes], y[kLanes];
    lanes.next2(kLanes, x, y);
    for (std::uint32_t k = 0; k < kLanes; ++k) EXPECT_EQ(samplers[k].next2(), Vec2(x[k], y[k])) << k;
  }
}

TEST(DirectLanes, SampleWhatLightsSampleOneByOne) {
  const auto scene = room(true);
  const Vec3 point{0.1f, 0.2f, -0.9f};
  DirectLanes lanes{};
  Rng rng(1, RngPurpose::pilot, 0, 0);
  std::array<Vec3, kLanes> random;
  float last[kLanes];
  for (std::uint32_t k = 0; k < kLanes; ++k) {
    const Vec2 u = rng.next2();
    random[k] = {u, rng.next()};
    lanes.point.set(k, point);
    lanes.random[0][k] = u.x;
    lanes.random[1][k] = u.y;
    last[k] = random[k].z;
  }
  std::array<std::uint32_t, kLanes> all;
  std::iota(all.begin(), all.end(), 0);
  std::uint32_t others[kLanes];
  const std::uint32_t other_count = scene->lights.begin_direct(scene->scene, all, last, lanes, others);
  lanes.sample(kLanes);
  int triangles = 0;
  for (std::uint32_t k = 0; k < kLanes; ++k) {
    if (std::count(others, others + other_count, k) > 0) continue;
    ++triangles;
    const DirectSample one = scene->lights.sample_direct(scene->scene, point, random[k]);
    // The same formulas in another order: some roundings.
    constexpr float kRounding = 1e-5f;
    EXPECT_LT(glm::distance(lanes.wi[k], one.wi), kRounding);
    EXPECT_LT(glm::distance(lanes.target[k], one.target), kRounding);
    EXPECT_LT(glm::distance(lanes.radiance[k], one.radiance), kRounding * (1 + glm::length(one.radiance)));
    if (!is_black(one.radiance)) {
      EXPECT_NEAR(lanes.pdf_w[k] / one.pdf_w, 1, kRounding);
    }
  }
  EXPECT_GT(triangles, 0);
  EXPECT_LT(triangles, static_cast<int>(kLanes)) << "point light and environment take their turns";
}

TEST(PowerHeuristic, BearsAnyDensities) {
  EXPECT_FLOAT_EQ(power_heuristic(3, 4), 9.0f / 25);
  EXPECT_EQ(power_heuristic(0, 4), 0);
  EXPECT_EQ(power_heuristic(0, 0), 0);
  EXPECT_FLOAT_EQ(power_heuristic(1e30f, 1e30f), 0.5f);
  EXPECT_FLOAT_EQ(power_heuristic(1e-30f, 1e-30f), 0.5f);
  EXPECT_EQ(power_heuristic(1e30f, 1e-30f), 1);
}

}  // namespace
}  // namespace photond
