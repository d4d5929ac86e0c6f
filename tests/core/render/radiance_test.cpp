// The renderer against scenes whose answer is known in closed form.
#include "core/render/radiance.h"

#include <gtest/gtest.h>

#include "core/render/render.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

using test::agrees;
using test::draw;
using test::Sample;

std::shared_ptr<const PhotonMaps> maps_of(const PreparedScene& scene, std::uint32_t photons, std::uint32_t pass = 0) {
  PhotonSettings settings;
  settings.photons_per_pass = photons;
  auto maps = build_photon_maps(scene, {scene.digest, settings, pass}, test::workers().execution());
  EXPECT_TRUE(maps.ok());
  return *maps;
}

// Mean over independent passes of what arrives along `ray`.
Sample measure(const PreparedScene& scene, Technique technique, const Ray& ray, std::uint32_t passes,
               std::uint32_t samples, std::uint32_t photons, float radius) {
  Sample means;
  for (std::uint32_t pass = 0; pass < passes; ++pass) {
    std::shared_ptr<const PhotonMaps> maps;
    RadianceSettings settings;
    settings.technique = technique;
    if (technique != Technique::trace) maps = maps_of(scene, photons, pass);
    settings.maps = maps.get();
    settings.radius_sq = radius * radius;
    double sum = 0;
    for (std::uint32_t i = 0; i < samples; ++i) {
      CameraSampler sampler(pass, 0, i);
      sum += estimate_incoming(scene, settings, ray, sampler).radiance.x;
    }
    means.add(sum / samples);
  }
  return means;
}

// A closed box whose walls emit Le and reflect a: L = Le/(1 − a) everywhere.
std::shared_ptr<const PreparedScene> furnace(float albedo) {
  Scene scene = test::empty_scene();
  Material wall = test::emitter(Rgb(1));
  wall.base_color = Rgb(albedo);
  test::add_mesh(scene, test::box({-1, -1, -1}, {1, 1, 1}, true), test::add_material(scene, wall));
  return test::prepared(std::move(scene));
}

const Ray kIntoTheFurnace{{0.1f, 0.2f, 0.3f}, glm::normalize(Vec3(0.3f, -0.8f, 0.45f))};

TEST(Furnace, PathTracingGivesTheGeometricSeries) {
  for (const float albedo : {0.0f, 0.5f, 0.9f}) {
    const auto scene = furnace(albedo);
    const Sample s = measure(*scene, Technique::trace, kIntoTheFurnace, 100, 400, 0, 0);
    EXPECT_TRUE(agrees(s, 1 / (1.0 - albedo))) << albedo << ": " << s.mean << " ± " << s.standard_error();
  }
}

TEST(Furnace, PhotonDensityGivesTheGeometricSeries) {
  const auto scene = furnace(0.5f);
  // The disc lies inside one wall, where the density is uniform: no bias.
  for (const Technique technique : {Technique::density, Technique::nearest, Technique::final_gather}) {
    const Sample s = measure(*scene, technique, kIntoTheFurnace, 40, 50, 20'000, 0.2f);
    EXPECT_TRUE(agrees(s, 2)) << static_cast<int>(technique) << ": " << s.mean << " ± " << s.standard_error();
  }
}

TEST(Furnace, EnvironmentIsSeenUnchangedThroughLosslessGlass) {
  Scene scene = test::empty_scene();
  scene.environment.radiance = Rgb(1);
  test::add_mesh(scene, test::sphere({0, 0, 0}, 1), test::add_material(scene, test::glass(1.5f)));
  const auto prepared = test::prepared(std::move(scene));
  for (const float x : {0.0f, 0.5f, 0.9f}) {
    const Sample s = measure(*prepared, Technique::trace, {{x, 0.1f, 3}, {0, 0, -1}}, 50, 100, 0, 0);
    EXPECT_TRUE(agrees(s, 1)) << x << ": " << s.mean << " ± " << s.standard_error();
  }
}

TEST(Furnace, WhiteConvexBodyVanishesInAUniformEnvironment) {
  Scene scene = test::empty_scene();
  scene.environment.radiance = Rgb(2);
  test::add_mesh(scene, test::box({-1, -1, -1}, {1, 1, 1}), test::add_material(scene, test::lambert(Rgb(1))));
  const auto prepared = test::prepared(std::move(scene));
  const Ray ray{{3, 2, 4}, glm::normalize(Vec3(-3, -2, -4))};
  EXPECT_TRUE(agrees(measure(*prepared, Technique::trace, ray, 50, 200, 0, 0), 2));
  // Convex: nothing is indirect, the photon map stays empty.
  EXPECT_TRUE(agrees(measure(*prepared, Technique::density, ray, 50, 200, 1000, 0.1f), 2));
}

// A white floor under a light; what leaves the floor is albedo/π · E.
struct Floor {
  Scene scene = test::empty_scene();
  Floor() {
    test::add_mesh(scene, test::parallelogram({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}),
                   test::add_material(scene, test::lambert(Rgb(0.5f))));
  }
  // Irradiance at the origin.
  Sample irradiance() {
    const auto prepared = test::prepared(std::move(scene));
    Sample s = measure(*prepared, Technique::trace, {{0.5f, 0, 0.5f}, glm::normalize(Vec3(-1, 0, -1))}, 200, 200, 0, 0);
    const double scale = kPi / 0.5;
    s.mean *= scale;
    s.m2 *= scale * scale;
    return s;
  }
};

// E = I cos³θ/h².
TEST(DirectLight, PointLightFollowsTheCosineCubed) {
  Floor floor;
  test::add_point_light(floor.scene, {1, 0, 2}, Rgb(10));
  const double cos_theta = 2 / std::sqrt(5.0);
  EXPECT_TRUE(agrees(floor.irradiance(), 10 * std::pow(cos_theta, 3) / 4));
}

// A rectangle X·h by Y·h with a corner above the point [hard cases, row 8].
TEST(DirectLight, RectangleMatchesItsFormFactor) {
  Floor floor;
  const double a = 1;
  const double b = 2;
  const double h = 1.5;
  test::add_mesh(floor.scene, test::parallelogram({0, 0, 1.5f}, {0, 2, 0}, {1, 0, 0}),
                 test::add_material(floor.scene, test::emitter(Rgb(3))));
  const double x = a / h;
  const double y = b / h;
  const double e = 3.0 / 2 * (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
                              y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y)));
  EXPECT_TRUE(agrees(floor.irradiance(), e));
}

// E = π L (R/d)² cos b. The sphere is a polyhedron: its projected area falls short by less than 3·10⁻³ at 48 rings.
TEST(DirectLight, SphereMatchesItsSolidAngle) {
  Floor floor;
  test::add_mesh(floor.scene, test::sphere({1, 0, 2}, 0.5f, 48),
                 test::add_material(floor.scene, test::emitter(Rgb(4))));
  const Sample e = floor.irradiance();
  const double expected = kPi * 4 * 0.25 / 5 * (2 / std::sqrt(5.0));
  EXPECT_NEAR(e.mean, expected, 3e-3 * expected + 4 * e.standard_error());
}

TEST(DirectLight, DirectionalLightGivesItsIrradianceTimesCosine) {
  Floor floor;
  PunctualLight sun;
  sun.type = LightType::directional;
  sun.direction = glm::normalize(Vec3(1, 0, -1));
  sun.intensity = Rgb(3);
  floor.scene.lights.push_back(sun);
  EXPECT_TRUE(agrees(floor.irradiance(), 3 * std::sqrt(0.5)));
}

TEST(DirectLight, SpotFadesByTheSquareOfTheCosinePosition) {
  for (const float x : {0.0f, 0.5f, 0.8f, 1.5f}) {
    Floor floor;
    PunctualLight spot;
    spot.type = LightType::spot;
    spot.position = {x, 0, 1};
    spot.direction = {0, 0, -1};
    spot.cos_inner = 0.95f;
    spot.cos_outer = 0.7f;
    spot.intensity = Rgb(2);
    floor.scene.lights.push_back(spot);
    const double cos_theta = 1 / std::sqrt(1.0 + x * x);
    const double t = std::clamp((cos_theta - 0.7) / 0.25, 0.0, 1.0);
    EXPECT_TRUE(agrees(floor.irradiance(), 2 * t * t * std::pow(cos_theta, 3))) << x;
  }
}

// A point light at the centre of a glass shell: all internal reflections escape, so outside E = I/d² as without it.
// Only photons find it: next-event estimation is blocked by the glass.
TEST(Caustics, LossLessShellAroundAPointLightChangesNothing) {
  Scene scene = test::empty_scene();
  const std::uint32_t glass = test::add_material(scene, test::glass(1.5f));
  test::add_mesh(scene, test::sphere({0, 0, 1}, 0.5f, 64), glass);
  Mesh inner = test::sphere({0, 0, 1}, 0.4f, 64);
  for (Vec3& n : inner.normals) n = -n;
  for (glm::uvec3& t : inner.triangles) std::swap(t.y, t.z);
  test::add_mesh(scene, inner, glass);
  test::add_mesh(scene, test::parallelogram({-5, -5, -1}, {10, 0, 0}, {0, 10, 0}),
                 test::add_material(scene, test::lambert(Rgb(0.5f))));
  test::add_point_light(scene, {0, 0, 1}, Rgb(10));
  const auto prepared = test::prepared(std::move(scene));
  const Ray ray{{3, 0, 0}, glm::normalize(Vec3(-3, 0, -1))};
  const Sample s = measure(*prepared, Technique::density, ray, 60, 1, 60'000, 0.15f);
  const double expected = 10.0 / 4 * 0.5 / kPi;
  // Bias: E = I h/(h² + ρ²)^1.5 averaged over the kernel (⟨ρ²⟩ = r²/3) is low by 1.5·r²/(3h²) = .3 %; facets add .5 %.
  EXPECT_NEAR(s.mean, expected, 0.008 * expected + 4 * s.standard_error());
}

// Collimated photons against the path tracer where both can see: a mirror lights the floor.
TEST(Caustics, ProgressiveAgreesWithPathTracing) {
  Scene scene = test::empty_scene();
  const std::uint32_t white = test::add_material(scene, test::lambert(Rgb(0.6f)));
  test::add_mesh(scene, test::box({-2, -2, 0}, {2, 2, 3}, true), white);
  test::add_mesh(scene, test::parallelogram({-1, -1.5f, 0.5f}, {2, 0, 0}, {0, 0, 1.5f}),
                 test::add_material(scene, test::mirror(Rgb(0.9f))));
  test::add_mesh(scene, test::parallelogram({-0.5f, 0, 2.9f}, {0, 1, 0}, {1, 0, 0}),
                 test::add_material(scene, test::emitter(Rgb(5))));
  const auto prepared = test::prepared(std::move(scene));
  const Ray ray{{0, 1, 1}, glm::normalize(Vec3(0.1f, -1.0f, -0.8f))};
  const Sample path = measure(*prepared, Technique::trace, ray, 100, 2000, 0, 0);
  const Sample density = measure(*prepared, Technique::density, ray, 100, 200, 50'000, 0.05f);
  const double error = std::hypot(path.standard_error(), density.standard_error());
  // .5 % for the density estimate's bias in a field that bends on the scale of a metre (r²/L² = .0025).
  EXPECT_NEAR(path.mean, density.mean, 4.1 * error + 0.005 * path.mean);
}

TEST(RenderPass, BitsDoNotDependOnTheThreads) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::box({-1, -1, -1}, {1, 1, 6}, true),
                 test::add_material(scene, test::lambert({0.7f, 0.5f, 0.4f})));
  test::add_mesh(scene, test::sphere({0, -0.4f, 0}, 0.5f), test::add_material(scene, test::glass(1.5f)));
  test::add_mesh(scene, test::parallelogram({-0.3f, 0.9f, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}),
                 test::add_material(scene, test::emitter(Rgb(10))));
  const auto prepared = test::prepared(std::move(scene));
  PhotonSettings photons;
  photons.photons_per_pass = 30'000;
  for (const Method method : {Method::path, Method::photon_map, Method::progressive}) {
    RenderSettings settings;
    settings.method = method;
    settings.width = 40;
    settings.height = 30;
    std::vector<Image> images;
    const Workers two(2);
    const Workers other(2);
    for (const Execution& execution : {Execution{}, two.execution(), other.execution()}) {
      const auto task = make_render_task(prepared, prepared->scene.cameras[0], photons, settings, execution);
      ASSERT_TRUE(task.ok());
      const MapSource maps = [&](const MapKey& key, const Execution& e) { return build_photon_maps(*prepared, key, e); };
      auto image = render_pass(*task, 3, maps, execution);
      ASSERT_TRUE(image.ok());
      images.push_back(std::move(image->radiance));
    }
    EXPECT_EQ(images[0].pixels, images[1].pixels) << method_name(method);
    EXPECT_EQ(images[0].pixels, images[2].pixels) << method_name(method);
  }
}

}  // namespace
}  // namespace photond
