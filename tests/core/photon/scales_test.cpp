#include "core/photon/scales.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/math/warp.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

using test::agrees;
using test::Sample;

/// A surface of one mesh to gather on.
struct Receiver {
  std::shared_ptr<const PreparedScene> scene;
  Edges edges;

  explicit Receiver(std::vector<Mesh> meshes, const Material& material = test::lambert(Rgb(1))) {
    Scene s = test::empty_scene();
    const std::uint32_t index = test::add_material(s, material);
    for (Mesh& mesh : meshes) test::add_mesh(s, std::move(mesh), index);
    scene = test::prepared(std::move(s));
    edges = Edges(scene->scene);
  }
  SurfacePoint look(const Ray& ray) const { return make_surface(scene->scene, ray, scene->accel.intersect(ray)); }
  ScaleEstimate gather(const PhotonMap& map, const Ray& ray, float radius, const Rgb& scale = Rgb(1),
                       std::uint32_t pass = 0) const {
    const SurfacePoint surface = look(ray);
    const Bsdf bsdf(scene->scene, surface, -ray.direction);
    ScaleEstimate sum;
    estimate_scales(map, surface, bsdf, bsdf.lobes(), Reach(edges, surface.position, surface.ng, radius),
                    radius * radius, scale, sum, {}, most_normal_factor(pass));
    return sum;
  }
};

Photon photon(const Vec3& position, const Vec3& normal, const Vec3& direction, const Rgb& flux = Rgb(1)) {
  return {position, encode_direction(direction), encode_normal(normal), nearest_flux(flux)};
}

/// `count` unit photons, uniform on a parallelogram, along its normal.
void lay(std::vector<Photon>& photons, Rng& rng, int count, const Vec3& origin, const Vec3& a, const Vec3& b) {
  const Vec3 normal = glm::normalize(glm::cross(a, b));
  for (int i = 0; i < count; ++i) {
    const Vec2 u = rng.next2();
    photons.push_back(photon(origin + u.x * a + u.y * b, normal, normal));
  }
}

Ray down(float x, float y) { return {{x, y, 1}, {0, 0, -1}}; }

/// The estimate at scale k, channel c, from the bands.
double level(const ScaleEstimate& e, int k, int c) {
  double sum = static_cast<double>(e.widest[c]);
  for (int j = 0; j < k; ++j) sum += static_cast<double>(e.bands.value[j][c]);
  return sum;
}

/// Against the formula, photon by photon in double, on surfaces of every kind and kernels that are whole or cut.
void expect_brute_force(const Receiver& receiver, const std::vector<Photon>& photons, const Ray& ray, float radius) {
  const PhotonMap map(photons, Execution{});
  const Rgb scale(0.5f, 2, 1);
  const ScaleEstimate found = receiver.gather(map, ray, radius, scale);
  const SurfacePoint surface = receiver.look(ray);
  const Bsdf bsdf(receiver.scene->scene, surface, -ray.direction);
  const Reach reach(receiver.edges, surface.position, surface.ng, radius);
  glm::dvec3 sums[kScales] = {};
  double squares[kBands] = {};
  for (std::uint32_t i = 0; i < map.size(); ++i) {
    const Vec3 offset = map.position(i) - surface.position;
    const double d_sq = glm::dot(glm::dvec3(offset), glm::dvec3(offset));
    if (glm::dot(map.normal(i), surface.ng) < 0.5f) continue;
    if (!reach.whole() && !reach.within(offset)) continue;
    const Vec3 wi = map.direction(i);
    if (glm::dot(wi, surface.ng) <= 0) continue;
    const float cosines = std::abs(glm::dot(wi, surface.ns)) / glm::dot(wi, surface.ng);
    const Rgb f = bsdf.eval(wi, bsdf.lobes(), Transport::radiance) * (surface.smooth ? std::min(cosines, 8.0f) : 1);
    const glm::dvec3 value = glm::dvec3(f * map.flux(i));
    double wider = 0;
    for (int k = 0; k < kScales; ++k) {
      const float r_sq = radius * radius / static_cast<float>(1 << (2 * k));
      const double kernel = std::max(0.0, 1 - d_sq / static_cast<double>(r_sq)) * 2 / std::numbers::pi /
                            static_cast<double>(r_sq * reach.coverage(r_sq));
      sums[k] += glm::dvec3(scale) * kernel * value;
      if (k > 0) squares[k - 1] += (kernel - wider) * (kernel - wider) * glm::dot(value * glm::dvec3(scale), value * glm::dvec3(scale));
      wider = kernel;
    }
  }
  ASSERT_GT(sums[kScales - 1].x, 0) << "the narrowest kernel must hold photons";
  for (int k = 0; k < kScales; ++k) {
    // Some hundred floats are summed, and differences of sums cancel.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(level(found, k, c), sums[k][c], 1e-4 * sums[kScales - 1][c]) << k;
    if (k == 0) continue;
    const double expected = squares[k - 1];
    // Factors are applied to the variance as if all photons had one colour: theirs differ by a fifth here.
    EXPECT_NEAR(static_cast<double>(found.bands.variance[k - 1]), expected, 0.1 * expected) << k;
  }
}

std::vector<Photon> mixed_floor(std::uint64_t seed) {
  std::vector<Photon> photons;
  Rng rng(seed, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < 20'000; ++i) {
    const float x = rng.next(), y = rng.next();
    const Vec3 direction = square_to_cosine_hemisphere(rng.next2());
    photons.push_back(photon({x, y, 0}, i % 5 == 0 ? Vec3(1, 0, 0) : Vec3(0, 0, 1), direction, {x, y, 0.5f}));
  }
  return photons;
}

TEST(Scales, EqualBruteForceOnALambertSurface) {
  const Receiver floor({test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0})}, test::lambert({0.8f, 0.5f, 0.2f}));
  for (const Ray& ray : {down(0.5f, 0.5f), down(0.03f, 0.4f), down(0.96f, 0.97f)}) {
    expect_brute_force(floor, mixed_floor(1), ray, 0.2f);
  }
}

TEST(Scales, EqualBruteForceOnALayeredSurface) {
  Material coated;
  coated.base_color = {0.8f, 0.5f, 0.2f};
  coated.metallic = 0.3f;
  coated.roughness = 0.5f;
  const Receiver floor({test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0})}, coated);
  for (const Ray& ray : {down(0.5f, 0.5f), down(0.03f, 0.4f)}) expect_brute_force(floor, mixed_floor(2), ray, 0.2f);
}

TEST(Scales, EqualBruteForceOnSmoothNormals) {
  Mesh tilted = test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  tilted.normals = {glm::normalize(Vec3(-1, 0, 2)), glm::normalize(Vec3(1, 0, 2)), glm::normalize(Vec3(1, 1, 2)),
                    glm::normalize(Vec3(0, 1, 3))};
  const Receiver floor({tilted});
  for (const Ray& ray : {down(0.3f, 0.5f), down(0.97f, 0.6f)}) expect_brute_force(floor, mixed_floor(3), ray, 0.2f);
}

// Photons of an even hemisphere bring to a normal that is tilted by β (1 + cos β)/2 of what they bring to the surface's own.
// Their weights have no bound; in later passes less and less is cut off.
TEST(Scales, TiltedNormalsLoseLessAndLessLight) {
  Mesh tilted = test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const double beta = 1;
  tilted.normals.assign(4, Vec3(std::sin(beta), 0, std::cos(beta)));
  const Receiver floor({tilted});
  std::vector<Photon> photons;
  constexpr int kSide = 512;
  Rng rng(5, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2 u = (Vec2(i % kSide, i / kSide) + rng.next2()) / static_cast<float>(kSide);
    photons.push_back(photon({0.5f, 0.5f, 0}, {0, 0, 1}, square_to_cosine_hemisphere(u)));
  }
  const PhotonMap map(photons, Execution{});
  const double highest = 2 / (std::numbers::pi * 0.16);   // of the kernel, where all of them lie
  const double expected = kSide * kSide * highest / std::numbers::pi * (1 + std::cos(beta)) / 2;
  const auto lost = [&](std::uint32_t pass) {
    const double found = static_cast<double>(floor.gather(map, down(0.5f, 0.5f), 0.4f, Rgb(1), pass).widest.x);
    return 1 - found / expected;
  };
  EXPECT_NEAR(lost(0), 0.03, 0.003);
  EXPECT_NEAR(lost(255), 0, 0.003);
}

TEST(Scales, NoPhotonsGiveNothing) {
  const Receiver floor({test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0})});
  const ScaleEstimate e = floor.gather(PhotonMap(std::vector<Photon>{}, Execution{}), down(0.5f, 0.5f), 0.2f);
  EXPECT_EQ(e.widest, Rgb(0));
  EXPECT_EQ(e.bands.variance[0], 0);
}

/// Hard case 30. On uniform photons the mean of every scale is the density, in the middle and, by renormalization, at a
/// plate's edges and corners; its bands are 0 and spread as they say.
TEST(ScalesStatistical, UniformDensityHasNoBandsUpToTheCorners) {
  const Receiver floor({test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0})});
  constexpr int kCount = 10'000;
  for (const Vec2& at : {Vec2(0.5f, 0.5f), Vec2(0.02f, 0.5f), Vec2(1e-6f, 0.4f), Vec2(0.03f, 0.02f), Vec2(1e-6f, 1e-6f)}) {
    Sample widest, bands[kBands], predicted[kBands];
    for (std::uint64_t n = 0; n < 500; ++n) {
      std::vector<Photon> photons;
      Rng rng(30, RngPurpose::pilot, 0, n);
      lay(photons, rng, kCount, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
      const ScaleEstimate e = floor.gather(PhotonMap(photons, Execution{}), down(at.x, at.y), 0.15f);
      const double unit = std::numbers::pi / kCount;
      widest.add(static_cast<double>(e.widest.x) * unit);
      for (int j = 0; j < kBands; ++j) {
        bands[j].add(static_cast<double>(e.bands.value[j].x) * unit);
        predicted[j].add(static_cast<double>(e.bands.variance[j]) / 3 * unit * unit);
      }
    }
    // Sectors approximate an edge: up to 1.5 % of the share they keep (Reach).
    const double slack = at.x < 0.1f ? 0.03 : 0;
    EXPECT_NEAR(widest.mean, 1, slack + test::kSigmas * widest.standard_error()) << at.x << " " << at.y;
    for (int j = 0; j < kBands; ++j) {
      EXPECT_NEAR(bands[j].mean, 0, slack + test::kSigmas * bands[j].standard_error()) << at.x << " " << at.y;
      // A variance of 500 values is known to √(2/500) = 6 %, more where few photons make tails; four of those.
      const double variance = bands[j].m2 / static_cast<double>(bands[j].count - 1);
      EXPECT_NEAR(predicted[j].mean / variance, 1, 0.3) << at.x << " " << at.y << ", band " << j;
    }
  }
}

/// Hard case 32: a lit room beside a dark one, a thin wall between them; the photons are on the floor and on the wall's
/// lit side.
TEST(Scales, NothingComesThroughAThinWall) {
  const Receiver rooms({test::parallelogram({0, 0, 0}, {2, 0, 0}, {0, 1, 0}), test::box({1, -0.5f, 0}, {1.01f, 1.5f, 1})});
  std::vector<Photon> photons;
  Rng rng(32, RngPurpose::pilot, 0, 0);
  lay(photons, rng, 20'000, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  lay(photons, rng, 20'000, {1, 0, 0}, {0, 0, 1}, {0, 1, 0});   // towards −x
  const PhotonMap map(photons, Execution{});
  const double lit = level(rooms.gather(map, down(0.5f, 0.5f), 0.2f), 0, 0);
  for (const float x : {1.011f, 1.02f, 1.05f, 1.1f}) {
    const ScaleEstimate dark = rooms.gather(map, down(x, 0.5f), 0.2f);
    // Sectors cut at one distance each: in those that hardly reach the wall a few photons beyond it remain.
    for (int k = 0; k < kScales; ++k) EXPECT_LE(level(dark, k, 0), 1e-3 * lit) << x << " " << k;
  }
  const ScaleEstimate behind = rooms.gather(map, {{2, 0.5f, 0.5f}, {-1, 0, 0}}, 0.2f);
  for (int k = 0; k < kScales; ++k) EXPECT_EQ(level(behind, k, 0), 0);
}

/// Hard case 33: in a crease of 90° neither side darkens.
TEST(ScalesStatistical, ACreaseIsNotDarker) {
  const Receiver crease({test::box({0, -1, 0}, {1, 2, 1}, true)});
  constexpr int kCount = 10'000;
  for (const float distance : {0.001f, 0.02f, 0.1f}) {
    Sample floor, wall;
    for (std::uint64_t n = 0; n < 300; ++n) {
      std::vector<Photon> photons;
      Rng rng(33, RngPurpose::pilot, 0, n);
      lay(photons, rng, kCount, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
      lay(photons, rng, kCount, {1, 0, 0}, {0, 0, 1}, {0, 1, 0});
      const PhotonMap map(photons, Execution{});
      const double unit = std::numbers::pi / kCount;
      floor.add(static_cast<double>(crease.gather(map, {{1 - distance, 0.5f, 0.5f}, {0, 0, -1}}, 0.15f).widest.x) * unit);
      wall.add(static_cast<double>(crease.gather(map, {{0.5f, 0.5f, distance}, {1, 0, 0}}, 0.15f).widest.x) * unit);
    }
    // 3 % by the sectors, as above.
    EXPECT_NEAR(floor.mean, 1, 0.03 + test::kSigmas * floor.standard_error()) << distance;
    EXPECT_NEAR(wall.mean, 1, 0.03 + test::kSigmas * wall.standard_error()) << distance;
  }
}

/// Of light whose étendue has no bound nothing is the photons', even where paths have no density.
TEST(Merge, UnboundedLightBelongsToPaths) {
  const Receiver receiver({test::parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})});
  const Ray ray = down(0, 0);
  const SurfacePoint surface = receiver.look(ray);
  const Bsdf bsdf(receiver.scene->scene, surface, -ray.direction);
  const Vec3 below(0.6f, 0, -0.8f);
  ASSERT_EQ(bsdf.pdf(below, bsdf.lobes()), 0);
  EXPECT_EQ(Merge{1}.ratio(surface, bsdf, bsdf.lobes(), below, kInfinity), kInfinity);
  EXPECT_EQ(Merge{1}.ratio(surface, bsdf, bsdf.lobes(), below, 1), 0);
}

}  // namespace
}  // namespace photond
