// Rooms and skies of uniform light, where every answer is a geometric series.
#include <gtest/gtest.h>

#include "tests/render/look.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

using namespace test;

// Two facets of a sphere meet at an angle δ; the ball of a density estimate across their edge holds up to δ²/4
// more area than the disc it is divided by: .2 % for 32 rings.
constexpr double kFacets = 0.002;

std::shared_ptr<const PreparedScene> in_a_sky(Mesh mesh, const Material& material, float radiance) {
  Scene scene = empty_scene();
  scene.environment.radiance = Rgb(radiance);
  add_mesh(scene, std::move(mesh), add_material(scene, material));
  return prepared(std::move(scene));
}

// A closed surface that emits `emission` and reflects `albedo`.
std::shared_ptr<const PreparedScene> furnace(Mesh mesh, const Rgb& albedo, const Rgb& emission = Rgb(1)) {
  Scene scene = empty_scene();
  Material wall = emitter(emission);
  wall.base_color = albedo;
  add_mesh(scene, std::move(mesh), add_material(scene, wall));
  return prepared(std::move(scene));
}

// A point of a convex body sees the sky over its whole hemisphere: L = a·Le.
TEST(HardCase, OpenFurnaceAroundAConvexBody01) {
  HardCase c(1, "open furnace");
  for (const float albedo : {0.3f, 1.0f}) {
    const auto scene = in_a_sky(box({-1, -1, -1}, {1, 1, 1}), lambert(Rgb(albedo)), 2);
    look_at_with(c.equals("L of a box of albedo " + std::string(albedo == 1 ? "1" : "0.3") + " under Le = 2",
                          2.0 * static_cast<double>(albedo)),
                 scene, {.from = {3, 2, 4}, .photons = 1000, .passes = 40, .side = 32});
  }
}

// A sky of texels is the sky it is made of: alike everywhere, or one half white, which a plane sees by halves.
TEST(HardCase, OpenFurnaceUnderAMap01) {
  HardCase c(1, "open furnace");
  Scene scene = empty_scene();
  scene.environment.radiance = Rgb(2);
  scene.environment.map = std::make_shared<EnvironmentMap>(16, 8, std::vector<Rgb>(16 * 8, Rgb(0.5f)));
  scene.environment.rotation = 1;
  add_mesh(scene, box({-1, -1, -1}, {1, 1, 1}), add_material(scene, lambert(Rgb(0.7f))));
  const Look look{.from = {3, 2, 4}, .photons = 1000, .passes = 40, .side = 32};
  look_at_with(c.equals("L of a box of albedo 0.7 under an even map of 1", 0.7), prepared(scene), look);
  // Rows 0 … 3 shine: halfway between the rows 3 and 4 radiance falls to zero, symmetrically about the horizon; of a
  // wall's hemisphere, half by the cosine's weight.
  std::vector<Rgb> halves(16 * 8, Rgb(0));
  std::fill(halves.begin(), halves.begin() + 16 * 4, Rgb(0.5f));
  scene.environment.map = std::make_shared<EnvironmentMap>(16, 8, halves);
  look_at_with(c.equals("L of its walls under a map whose upper half is 1", 0.35), prepared(scene),
               {.from = {0.2f, 0.1f, 4}, .at = {0.2f, 0.1f, 1}, .photons = 1000, .passes = 40, .side = 32});
}

// Sun and sky of one picture: E = ∫ L cos θ dω over the map itself.
TEST(HardCase, OpenFurnaceUnderASun01) {
  HardCase c(1, "open furnace");
  std::vector<Rgb> pixels(64 * 32, Rgb(0.1f));
  pixels[64 * 9 + 20] = Rgb(5000);
  const auto map = std::make_shared<EnvironmentMap>(64, 32, pixels);
  double irradiance = 0;
  constexpr int kColumns = 64 * 16, kRows = 512;   // of the texels' sixteenths
  for (int y = 0; y < kRows; ++y) {
    const double theta = (y + 0.5) / kRows * std::numbers::pi;
    for (int x = 0; theta < std::numbers::pi / 2 && x < kColumns; ++x) {
      const double phi = (x + 0.5) / kColumns * 2 * std::numbers::pi;
      const Vec3 w(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
      irradiance += static_cast<double>(map->radiance(w).x) * std::cos(theta) * std::sin(theta) *
                    (std::numbers::pi / kRows) * (2 * std::numbers::pi / kColumns);
    }
  }
  Scene scene = empty_scene();
  scene.environment.radiance = Rgb(1);
  scene.environment.map = map;
  add_mesh(scene, parallelogram({-1, 0, -1}, {0, 0, 2}, {2, 0, 0}), add_material(scene, lambert(Rgb(0.5f))));
  // The quadrature's midpoints miss a tent's integral by (1/16)²/4 = .1 % at most.
  look_at_with(c.equals("L of a plane of albedo 0.5 under a sun of one texel", 0.5 * irradiance / std::numbers::pi,
                        {.relative = 0.001}),
               prepared(std::move(scene)), {.from = {1, 2, 1}, .photons = 1000, .passes = 40, .side = 32});
}

// Whatever its shape, a body that loses nothing hides nothing: L = Le.
TEST(HardCaseStatistical, OpenFurnaceAroundAHollow01) {
  HardCase c(1, "open furnace");
  Mesh tub = box({-1, -1, 0}, {1, 1, 1}, true);
  std::erase_if(tub.triangles, [&](const glm::uvec3& t) {
    return tub.positions[t.x].z + tub.positions[t.y].z + tub.positions[t.z].z == 3;
  });
  const auto scene = in_a_sky(tub, lambert(Rgb(1)), 1);
  const Look look{.from = {0.3f, 0.2f, 2},
                  .at = {0.1f, 0.1f, 0},
                  .radius = 0.15f,
                  .photons = 60'000,
                  .passes = 60,
                  .side = 32};
  std::vector<Method> exact = kMethods;
  std::erase(exact, Method::photon_map);
  // The kernel's bias where the indirect half of the light bends on the scale of 1 m: (r/L)²/3/2.
  look_at_with(c.equals("L inside a white tub", 1, {.relative = 0.004, .precision = 0.025}), scene, look,
               exact);
  // Final-gather rays end near the tub's edges too, where the ball of 64 photons reaches over the edge: in a
  // strip as wide as its radius (.06 m of walls 1 m high, with three edges) a fifth of the estimate is missing.
  look_at_with(c.equals("the same by final gather", 1, {.relative = 0.03, .precision = 0.025}), scene, look,
               {Method::photon_map});
}

// Smooth glass takes n² and gives it back: L = Le.
TEST(HardCase, OpenFurnaceThroughGlass01) {
  HardCase c(1, "open furnace");
  Quantity& q = c.equals("L through a smooth glass sphere", 1);
  const auto scene = in_a_sky(sphere({0, 0, 0}, 1), glass(1.5f), 1);
  for (const float x : {0.0f, 0.5f, 0.9f}) {
    look_at_with(q, scene,
                 {.from = {x, 3, 0.1f}, .at = {x, 0, 0.1f}, .photons = 1000, .passes = 40, .side = 8});
  }
}

// L = Le + a·L, so L = Le/(1 − a).
void closed_furnace(float albedo, const Look& budget) {
  HardCase c(2, "closed furnace");
  const auto scene = furnace(faceted(inside_out(sphere({0, 0, 0}, 1))), Rgb(albedo));
  char what[40];
  std::snprintf(what, sizeof what, "L at albedo %g", static_cast<double>(albedo));
  Look look = budget;
  look.from = {0.1f, 0.2f, 0.3f};
  look.at = {0.3f, -0.8f, 0.45f};
  look.radius = 0.2f;
  look_at_with(c.equals(what, 1 / (1 - static_cast<double>(albedo)), {.relative = kFacets}), scene, look);
}

TEST(HardCase, ClosedFurnace02) {
  closed_furnace(0, {.photons = 500, .passes = 20, .side = 8});
  closed_furnace(0.5f, {.photons = 5000, .passes = 30, .side = 24});
}

TEST(HardCaseStatistical, ClosedFurnace02) {
  closed_furnace(0.9f, {.photons = 6000, .passes = 24, .side = 24});
}

// After D bounces: L = Σ_{k=0..D} Le·a^k = Le (1 − a^{D+1})/(1 − a), whichever technique finds the last light.
TEST(HardCase, TruncatedFurnace02) {
  HardCase c(2, "closed furnace");
  const auto scene = furnace(box({-1, -1, -1}, {1, 1, 1}, true), Rgb(0.5f));
  for (const std::uint32_t bounces : {2u, 4u}) {
    look_at_with(c.equals("L cut after " + std::to_string(bounces) + " bounces at albedo 0.5",
                          (1 - std::pow(0.5, bounces + 1)) / 0.5),
                 scene,
                 {.from = {0.1f, 0.2f, 0.3f},
                  .at = {0.3f, -0.8f, 0.45f},
                  .passes = 60,
                  .side = 16,
                  .max_depth = bounces},
                 {Method::path});
  }
}

// Le/(1 − .999) = 1000 Le needs some 7000 bounces for .1 %: roulette must not lose what it cuts, and no limit
// may cut.
TEST(HardCaseStatistical, WhiteFurnace03) {
  HardCase c(3, "furnace of albedo 0.999");
  const auto scene = furnace(box({-1, -1, -1}, {1, 1, 1}, true), Rgb(0.999f));
  std::vector<Method> methods = kMethods;
  std::erase(methods, Method::photon_map);  // gathers in corners too, like progressive's probe does not
  // The walk's length is geometric with mean and deviation 1000: one path tells the mean within 100 %.
  look_at_with(c.equals("L", 1 / (1 - static_cast<double>(0.999f)), {.precision = 0.03}), scene,
               {.from = {0.1f, 0.2f, 0.3f},
                .at = {0.3f, -0.8f, 0.45f},
                .radius = 0.5f,
                .photons = 400,
                .passes = 20,
                .side = 12},
               methods);
  Quantity& cut = c.at_most("share of the photons' flux cut by a depth limit", 1e-6);
  for (const std::uint64_t seed : kSeeds) {
    const EnergyLedger e = shoot_maps(*scene, 2000, seed)->ledger;
    cut.add(std::to_string(seed), e.truncated / e.emitted);
  }
}

// A sphere of area S with a port of the fraction f, lit inside with Φ. Every point of a sphere sees every other
// alike, so that what is reflected is incident uniformly: E = aΦ/S + a(1 − f)E gives E = (Φ/S)·a/(1 − a(1 −
// f)).
TEST(HardCaseStatistical, IntegratingSphere04) {
  HardCase c(4, "integrating sphere");
  constexpr float kAlbedo = 0.8f;
  Scene scene = empty_scene();
  Mesh wall = faceted(inside_out(sphere({0, 0, 0}, 1, 48)));
  std::erase_if(wall.triangles, [&](const glm::uvec3& t) {
    return wall.positions[t.x].y + wall.positions[t.y].y + wall.positions[t.z].y > 3 * 0.9f;
  });
  double area = 0;
  float port = 1;  // y of the rim
  for (const glm::uvec3& t : wall.triangles) {
    const Vec3 a = wall.positions[t.x], b = wall.positions[t.y], d = wall.positions[t.z];
    area += 0.5 * static_cast<double>(glm::length(glm::cross(b - a, d - a)));
  }
  port = 0;
  for (const glm::uvec3& t : wall.triangles) port = std::max(port, wall.positions[t.x].y);
  const double f = (1 - static_cast<double>(port)) / 2;
  const double whole = area / (1 - f);
  add_mesh(scene, wall, add_material(scene, lambert(Rgb(kAlbedo))));
  PunctualLight spot;
  spot.type = LightType::spot;
  spot.direction = {0, -1, 0};
  spot.cos_inner = 0.95f;
  spot.cos_outer = 0.9f;
  spot.intensity = Rgb(10);
  scene.lights.push_back(spot);
  const double flux = 2 * std::numbers::pi * 10 * (0.05 + 0.05 / 3);
  const auto room = prepared(std::move(scene));
  const double a = static_cast<double>(kAlbedo);
  const double e = flux / whole * a / (1 - a * (1 - f));
  look_at_with(c.equals("indirect irradiance", e, {.relative = kFacets, .precision = 0.02}), room,
               {.from = {0.1f, 0.2f, 0},
                .at = {0.95f, 0.1f, 0.2f},
                .radius = 0.2f,
                .photons = 10'000,
                .passes = 100,
                .side = 32},
               kMethods, std::numbers::pi / a);

  // The places of successive hits are independent and uniform. Facets are planar, so rings and meridians bound
  // them.
  Quantity& p = c.at_most("1 − p of χ² of the hits over rings × sectors", 1 - kSignificance);
  for (const std::uint64_t seed : kSeeds) {
    const auto maps = shoot_maps(*room, 100'000, seed);
    constexpr int kRings = 48, kSectors = 8;
    std::vector<double> observed(kRings * kSectors, 0), expected(kRings * kSectors, 0);
    const auto cell = [](const Vec3& at) {
      int ring = 0;
      while (ring + 1 < kRings && at.y < std::cos(kPi * static_cast<float>(ring + 1) / kRings)) ++ring;
      const float turn = std::atan2(-at.z, at.x) / (2 * kPi);
      return static_cast<std::size_t>(
          ring * kSectors + std::min(static_cast<int>((turn < 0 ? turn + 1 : turn) * kSectors), kSectors - 1));
    };
    for (std::uint32_t i = 0; i < maps->global.size(); ++i) ++observed[cell(maps->global.position(i))];
    const Mesh& placed = room->scene.meshes[0];
    for (const glm::uvec3& t : placed.triangles) {
      const Vec3 x = placed.positions[t.x], y = placed.positions[t.y], z = placed.positions[t.z];
      expected[cell((x + y + z) / 3.0f)] +=
          maps->global.size() * 0.5 * static_cast<double>(glm::length(glm::cross(y - x, z - x))) / area;
    }
    p.add(std::to_string(seed), 1 - chi2_test(observed, expected));
  }
}

// White bodies in glass: seen from outside they vanish (L = Le); inside the glass radiance is n²Le. Camera
// paths are scaled by n² at refractions, photons are not. The body's radius is below R/n, so that no light is
// trapped.
TEST(HardCaseStatistical, WhiteBodyInsideGlass14) {
  HardCase c(14, "white body in glass in a sky");
  Scene scene = empty_scene();
  scene.environment.radiance = Rgb(1);
  add_mesh(scene, faceted(sphere({0, 0, 0}, 1, 48)), add_material(scene, glass(1.5f)));
  add_mesh(scene, faceted(sphere({0, 0, 0}, 0.5f, 48)), add_material(scene, lambert(Rgb(1))));
  const auto room = prepared(std::move(scene));
  const Look look{.radius = 0.15f, .photons = 60'000, .passes = 60, .side = 8};
  Look outside = look;
  outside.from = {3, 0.3f, 0.2f};
  outside.at = {0, 0.05f, 0.03f};
  // Convex facets: less area in the ball than in the disc, as above.
  look_at_with(c.equals("L from outside", 1, {.relative = kFacets, .precision = 0.02}), room, outside);
  Look inside = look;
  inside.from = {0.8f, 0.1f, 0.1f};
  inside.at = {0, 0.05f, 0.03f};
  look_at_with(c.equals("L inside the glass: n²", 2.25, {.relative = kFacets, .precision = 0.02}), room,
               inside);
}

// Each channel is a furnace of its own; roulette goes by the brightest.
TEST(HardCaseStatistical, SaturatedFurnace28) {
  HardCase c(28, "saturated light (1, .001, .001) and walls (.99, .01, .01)");
  const auto scene =
      furnace(faceted(inside_out(sphere({0, 0, 0}, 1, 24))), {0.99f, 0.01f, 0.01f}, {1, 1e-3f, 1e-3f});
  const Look look{.from = {0.1f, 0.2f, 0.3f},
                  .at = {0.3f, -0.8f, 0.45f},
                  .radius = 0.3f,
                  .photons = 1000,
                  .passes = 40,
                  .side = 8};
  // δ²/4 at 24 rings.
  look_at_with(c.equals("red", 1 / (1 - static_cast<double>(0.99f)), {.relative = 0.004, .precision = 0.03}),
               scene, look);
  look_at_with(c.equals("green", 1e-3 / 0.99, {.relative = 0.004}), scene, look, kMethods, 1, 1);
}

}  // namespace
}  // namespace photond
