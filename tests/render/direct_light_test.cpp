// Light that arrives without a detour, against form factors in closed form. No method needs photons here, and
// none may be disturbed by them.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/render/look.h"
#include "tests/support/estimate.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

using namespace test;

constexpr double kPiD = std::numbers::pi;

// A floor at z = 0; what leaves it is albedo/π · E.
struct Floor {
  Scene scene = empty_scene();
  Floor() {
    add_mesh(scene, parallelogram({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}),
             add_material(scene, lambert(Rgb(0.5f))));
  }
  void add_emitter(Mesh mesh, float radiance) {
    add_mesh(scene, std::move(mesh), add_material(scene, emitter(Rgb(radiance))));
  }
  // Measures the irradiance at the origin.
  void irradiance(Quantity& quantity) {
    look_at_with(quantity, prepared(std::move(scene)),
                 {.from = {0.5f, 0, 0.5f}, .photons = 500, .passes = 50, .side = 32}, kMethods, kPiD / 0.5);
  }
};

TEST(HardCase, PointLight05) {
  HardCase c(5, "point light above a plane");
  for (const float x : {0.0f, 1.0f, 4.0f}) {
    Floor floor;
    add_point_light(floor.scene, {x, 0, 2}, Rgb(10));
    const double cosine = 2 / std::sqrt(4 + static_cast<double>(x) * x);
    floor.irradiance(c.equals("E = I cos³θ/h² at " + std::to_string(static_cast<int>(x)) + " m beside",
                              10 * std::pow(cosine, 3) / 4));
  }
}

// A spot fades by the square of the cosine's place between its cones.
TEST(HardCase, SpotLight05) {
  HardCase c(5, "point light above a plane");
  for (const float x : {0.0f, 0.5f, 0.8f, 1.5f}) {
    Floor floor;
    PunctualLight spot;
    spot.type = LightType::spot;
    spot.position = {x, 0, 1};
    spot.cos_inner = 0.95f;
    spot.cos_outer = 0.7f;
    spot.intensity = Rgb(2);
    floor.scene.lights.push_back(spot);
    const double cosine = 1 / std::sqrt(1 + static_cast<double>(x) * x);
    const double t = std::clamp((cosine - 0.7) / 0.25, 0.0, 1.0);
    char what[40];
    std::snprintf(what, sizeof what, "E of a spot %g m beside", static_cast<double>(x));
    floor.irradiance(c.equals(what, 2 * t * t * std::pow(cosine, 3)));
  }
}

// However narrow a beam is, it has its full intensity within the inner cone: pointers of .1 to 10 milliradians.
TEST(DirectLight, NarrowBeamsAreAsBrightAsWideOnes) {
  for (const float angle : {1e-4f, 1e-3f, 1e-2f}) {
    Floor floor;
    PunctualLight spot;
    spot.type = LightType::spot;
    spot.position = {0, 0, 1};
    spot.cos_inner = std::cos(static_cast<double>(angle));
    spot.cos_outer = std::cos(1.5 * static_cast<double>(angle));
    spot.intensity = Rgb(2);
    floor.scene.lights.push_back(spot);
    const auto room = prepared(std::move(floor.scene));
    const Sample seen = see(room, Method::path, 1, {.from = {0, 0.5f * angle, 0.5f}, .at = {0, 0.5f * angle, 0}})[0];
    EXPECT_NEAR(seen.mean, 0.5 / kPiD * 2, 1e-4) << angle;
    // π I [a² + (b² − a²)/3] of a cone so narrow.
    const double power = kPiD * 2 * static_cast<double>(angle) * static_cast<double>(angle) * (1 + 1.25 / 3);
    const EnergyLedger ledger = shoot_maps(*room, 20'000, 1)->ledger;
    EXPECT_NEAR(ledger.emitted / power, 1, 0.02) << angle;
  }
}

TEST(HardCase, DirectionalLight05) {
  HardCase c(5, "point light above a plane");
  Floor floor;
  PunctualLight sun;
  sun.type = LightType::directional;
  sun.direction = glm::normalize(Vec3(1, 0, -1));
  sun.intensity = Rgb(3);
  floor.scene.lights.push_back(sun);
  floor.irradiance(c.equals("E of a directional light at 45°", 3 * std::sqrt(0.5)));
}

TEST(HardCase, SphereLight06) {
  HardCase c(6, "sphere light");
  for (const float x : {0.0f, 1.0f, 6.0f}) {
    Floor floor;
    floor.add_emitter(sphere({x, 0, 2}, 0.5f, 64), 4);
    const double distance_sq = 4 + static_cast<double>(x) * x;
    // A polyhedron inside the sphere: its outline falls short by less than (π/64)²/6·2 = .08 %, at most .1 %.
    floor.irradiance(c.equals("E = πL(R/d)² cos b at " + std::to_string(static_cast<int>(x)) + " m beside",
                              kPiD * 4 * 0.25 / distance_sq * 2 / std::sqrt(distance_sq), {.relative = 0.001}));
  }
}

TEST(HardCase, DiskLight07) {
  HardCase c(7, "disk light parallel to the plane");
  const double r = 0.7, h = 1.5;
  // The polygon of 256 corners lacks (2π/256)²/6 = .01 % of the disk.
  const Tolerance polygon{.relative = 1e-4};
  {
    Floor floor;
    floor.add_emitter(disk({0, 0, 1.5f}, {0, 0, -1}, 0.7f), 3);
    floor.irradiance(c.equals("E = πLR²/(R² + h²) on the axis", kPiD * 3 * r * r / (r * r + h * h), polygon));
  }
  const double a = 1.2;
  Floor floor;
  floor.add_emitter(disk({1.2f, 0, 1.5f}, {0, 0, -1}, 0.7f), 3);
  const double hh = h / a, rr = r / a, z = 1 + hh * hh + rr * rr;
  floor.irradiance(c.equals("E = πL/2 (1 − (Z − 2R²)/√(Z² − 4R²)) off the axis",
                            kPiD * 3 / 2 * (1 - (z - 2 * rr * rr) / std::sqrt(z * z - 4 * rr * rr)), polygon));
}

// Lambert: E = (L/2) Σ θᵢ (n·Γᵢ) over the edges, θᵢ the angle an edge subtends, Γᵢ the normal of its plane.
double polygon_irradiance(const std::vector<glm::dvec3>& corners, double radiance) {
  double sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec3 a = glm::normalize(corners[i]);
    const glm::dvec3 b = glm::normalize(corners[(i + 1) % corners.size()]);
    sum += std::acos(glm::dot(a, b)) * glm::normalize(glm::cross(a, b)).z;
  }
  return radiance / 2 * std::abs(sum);
}

TEST(HardCase, PolygonLight08) {
  HardCase c(8, "polygon light");
  {
    Floor floor;
    floor.add_emitter(parallelogram({0, 0, 1.5f}, {0, 2, 0}, {1, 0, 0}), 3);
    const double x = 1 / 1.5, y = 2 / 1.5;
    floor.irradiance(c.equals("E below the corner of a rectangle",
                              1.5 * (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
                                     y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y)))));
  }
  Floor floor;
  Mesh triangle;
  triangle.positions = {{0.3f, -0.5f, 1}, {-0.6f, 0.4f, 1.7f}, {1.2f, 0.8f, 0.6f}};
  triangle.triangles = {{0, 1, 2}, {0, 2, 1}};  // whichever side faces the floor
  std::vector<glm::dvec3> corners(triangle.positions.begin(), triangle.positions.end());
  floor.add_emitter(triangle, 3);
  floor.irradiance(c.equals("E below a tilted triangle", polygon_irradiance(corners, 3)));
}

// The share of a Lambert emitter's photons that a black receiver absorbs is the form factor.
TEST(HardCase, FormFactorsByPhotonCounts09) {
  HardCase c(9, "form factors of unit squares by photon counts");
  const auto measure = [](Quantity& quantity, const Mesh& light, const Mesh& receiver) {
    Scene scene = empty_scene();
    add_mesh(scene, light, add_material(scene, emitter(Rgb(1))));
    add_mesh(scene, receiver, add_material(scene, lambert(Rgb(0))));
    const auto room = prepared(std::move(scene));
    for (const std::uint64_t seed : kSeeds) {
      Sample share;
      for (std::uint32_t pass = 0; pass < 20; ++pass) {
        const EnergyLedger e = shoot_maps(*room, 20'000, seed, pass)->ledger;
        share.add(e.absorbed / e.emitted);
      }
      quantity.add("seed " + std::to_string(seed), share);
    }
  };
  const double x = std::sqrt(2.0);
  measure(c.equals("parallel at distance 1",
                   2 / kPiD * (0.5 * std::log(4.0 / 3) + 2 * x * std::atan(1 / x) - 2 * std::atan(1.0))),
          parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), parallelogram({0, 0, 1}, {0, 1, 0}, {1, 0, 0}));
  measure(
      c.equals("perpendicular with a common edge",
               1 / kPiD * (2 * std::atan(1.0) - x * std::atan(1 / x) + 0.25 * std::log(4.0 / 3 * 0.75 * 0.75))),
      parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), parallelogram({0, 0, 0}, {0, 1, 0}, {0, 0, 1}));
}

// Between infinite plates B₁ = E₁ + a₁B₂ and B₂ = E₂ + a₂B₁. Walls of ideal mirrors make plates infinite.
TEST(HardCaseStatistical, InfinitePlates09) {
  HardCase c(9, "infinite plates, by mirrors around them");
  Scene scene = empty_scene();
  Material below = emitter(Rgb(1));
  below.base_color = Rgb(0.6f);
  Material above = emitter(Rgb(3));
  above.base_color = Rgb(0.4f);
  add_mesh(scene, parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), add_material(scene, below));
  add_mesh(scene, parallelogram({-1, -1, 1}, {0, 2, 0}, {2, 0, 0}), add_material(scene, above));
  Mesh sides = box({-1, -1, 0}, {1, 1, 1}, true);
  std::erase_if(sides.triangles, [&](const glm::uvec3& t) {
    return sides.positions[t.x].z == sides.positions[t.y].z && sides.positions[t.y].z == sides.positions[t.z].z;
  });
  add_mesh(scene, sides, add_material(scene, mirror(Rgb(1))));
  const auto room = prepared(std::move(scene));
  const double a1 = static_cast<double>(0.6f), a2 = static_cast<double>(0.4f);
  const double radiosity = (1 + a1 * 3) / (1 - a1 * a2);
  const Look look{.from = {0.1f, 0.2f, 0.7f},
                  .at = {-0.1f, 0.1f, 0},
                  .radius = 0.15f,
                  .photons = 10'000,
                  .passes = 60,
                  .side = 8};
  std::vector<Method> exact = kMethods;
  std::erase(exact, Method::photon_map);
  look_at_with(c.equals("B₁ = (E₁ + a₁E₂)/(1 − a₁a₂)", radiosity), room, look, exact);
  // Final-gather rays end beside the mirrors too, where the ball reaches over the plate's edge: 64 of some 15
  // 000 photons on 4 m² lie within .07 m, in a strip of 14 % a fifth is missing, of the indirect part (a fifth
  // of B₁).
  look_at_with(c.equals("the same by final gather", radiosity, {.relative = 0.01}), room, look,
               {Method::photon_map});
}

// A hundredth of a degree above the plane: E = I sin(.01°)/d².
TEST(HardCase, GrazingLight24) {
  HardCase c(24, "light 0.01° above the plane");
  const double angle = 0.01 * kPiD / 180;
  {
    Floor floor;
    add_point_light(floor.scene, {static_cast<float>(std::cos(angle)), 0, static_cast<float>(std::sin(angle))},
                    Rgb(10));
    // The points seen lie 10⁻⁴ m around the origin (E changes by 3·10⁻⁴ there, odd in the offset).
    floor.irradiance(c.equals("E of a point light at 1 m", 10 * std::sin(angle), {.relative = 1e-3}));
  }
  Floor floor;
  PunctualLight sun;
  sun.type = LightType::directional;
  sun.direction = Vec3(static_cast<float>(-std::cos(angle)), 0, static_cast<float>(-std::sin(angle)));
  sun.intensity = Rgb(3);
  floor.scene.lights.push_back(sun);
  floor.irradiance(c.equals("E of a directional light", 3 * std::sin(angle), {.relative = 1e-5}));
}

// On interpolated normals |ω·ns|/|ω·ng| grows without limit as light grazes the facets. Photons that a mirror
// sends 0.01° above a floor whose normals lean 5° towards them arrive as E = E₀ sin(.01°) by the true surface,
// and by the shaded one 500 times as much: the estimate gives 8 times, its bound, and no more.
TEST(HardCase, GrazingPhotonsOnShadingNormals24) {
  HardCase c(24, "light 0.01° above the plane");
  const double angle = 0.01 * kPiD / 180;
  std::vector<Photon> photons;
  const Vec3 towards{static_cast<float>(std::cos(angle)), 0, static_cast<float>(std::sin(angle))};
  Rng rng(5, RngPurpose::pilot, 24, 0);
  constexpr int kPhotons = 20'000;
  for (int i = 0; i < kPhotons; ++i) {
    const Vec2 p = rng.next2();
    photons.push_back({{p.x, p.y, 0}, encode_direction(towards), encode_normal({0, 0, 1}), nearest_flux(Rgb(1))});
  }
  const PhotonMap map(photons, Execution{});
  Scene scene = empty_scene();
  Mesh plate = parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  plate.normals.assign(4, {std::sin(0.0873f), 0, std::cos(0.0873f)});
  add_mesh(scene, plate, add_material(scene, lambert(Rgb(1))));
  const auto room = prepared(std::move(scene));
  const Ray ray{{0.5f, 0.5f, 1}, {0, 0, -1}};
  const SurfacePoint s = make_surface(room->scene, ray, room->accel.intersect(ray));
  const Bsdf bsdf(room->scene, s, {0, 0, 1});
  const double seen =
      kPiD * static_cast<double>(test::estimate_radiance(map, s, bsdf, kDiffuseLobe, 0.01f).x);
  // 600 photons in the disc: 5 % noise of the count, of the Epanechnikov kernel 6 %; four sigmas.
  c.equals("estimate over the photons' density", 8, {.relative = 0.25}).add("", seen / kPhotons);
}

}  // namespace
}  // namespace photond
