// Light by way of glass, where the way can be unfolded.
#include <gtest/gtest.h>

#include <numbers>

#include "core/trace/microfacet.h"
#include "tests/render/look.h"
#include "tests/support/estimate.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

using namespace test;

constexpr double kPiD = std::numbers::pi;
// So dark a floor that what it sends into the scene and back is at most a thousandth of what arrives.
constexpr float kDark = 1e-3f;

double fresnel(double cosine, double eta) {
  const double sine_sq = (1 - cosine * cosine) / (eta * eta);
  if (sine_sq >= 1) return 1;
  const double t = std::sqrt(1 - sine_sq);
  const double s = (cosine - eta * t) / (cosine + eta * t), p = (eta * cosine - t) / (eta * cosine + t);
  return (s * s + p * p) / 2;
}

// Light 1 m above flat water .5 m deep: on the axis E = T I/(h₁ + h₂/n)², T = 1 − ((n − 1)/(n + 1))².
TEST(HardCase, FlatWater11) {
  HardCase c(11, "point light above flat water, on the axis");
  Scene scene = empty_scene();
  add_mesh(scene, parallelogram({-2, -2, -0.5f}, {4, 0, 0}, {0, 4, 0}),
           add_material(scene, lambert(Rgb(kDark))));
  add_mesh(scene, parallelogram({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}), add_material(scene, glass(1.33f)));
  scene.lights.push_back(spot_light({0, 0, 1}, {0, 0, -1}, 0.995f, 0.99f, 10));
  const auto room = prepared(std::move(scene));
  const double n = static_cast<double>(1.33f);
  const double t = 1 - (n - 1) * (n - 1) / ((n + 1) * (n + 1));
  // E falls like cos⁴: by 2ρ²/d² on average, ⟨ρ²⟩ = r²/3 of the kernel, d = 1.4 m: .09 % at r = .05 m; .1 %
  // comes back from the floor.
  look_at_with(
      c.equals("E = T I/(h₁ + h₂/n)²", t * 10 / std::pow(1 + 0.5 / n, 2),
               {.relative = 0.002, .precision = 0.025}),
      room,
      {.from = {0.2f, 0.1f, -0.2f}, .at = {0, 0, -0.5f}, .radius = 0.05f, .photons = 10'000, .passes = 80},
      photon_methods(), kPiD / static_cast<double>(kDark));
}

// Inside lossless concentric shells a point light shines as without: every internal reflection leaves in the
// end, along a line through the centre. The receiver is a dark sphere of 2 m; its curvature biases nothing
// (case 31).
TEST(HardCaseStatistical, LightInsideGlass12) {
  HardCase c(12, "point light at the centre of glass shells");
  for (const int shells : {1, 2}) {
    Scene scene = empty_scene();
    const std::uint32_t shell = add_material(scene, glass(1.5f));
    for (int i = 0; i < shells; ++i) {
      const float radius = 0.5f + 0.5f * static_cast<float>(i);
      add_mesh(scene, sphere({0, 0, 0}, radius, 64), shell);
      add_mesh(scene, inside_out(sphere({0, 0, 0}, 0.8f * radius, 64)), shell);
    }
    add_mesh(scene, faceted(inside_out(sphere({0, 0, 0}, 2, 64))), add_material(scene, lambert(Rgb(kDark))));
    add_point_light(scene, {0, 0, 0}, Rgb(10));
    const auto room = prepared(std::move(scene));
    const std::string name = std::to_string(shells) + (shells == 1 ? " shell" : " shells");
    // Facets of the receiver: π/64 bends the ball's area by δ²/4 = .06 % and brings the wall .06 % nearer (E +
    // .12 %); the floor sends .1 % back.
    look_at_with(
        c.equals("E = I/d² outside " + name, 2.5, {.relative = 0.003, .precision = 0.025}), room,
        {.from = {0.1f, 1.3f, 0.1f}, .at = {0.3f, 2, 0.2f}, .radius = 0.4f, .photons = 20'000, .passes = 40},
        photon_methods(), kPiD / static_cast<double>(kDark));
    // Stored fluxes are rounded at random to 1/256: 10⁻⁵ in the sum of twenty thousand.
    Quantity& flux = c.equals("photons' flux outside " + name, 40 * kPiD, {.relative = 5e-5});
    for (const std::uint64_t seed : kSeeds) {
      const auto maps = shoot_maps(*room, 20'000, seed);
      flux.add("seed " + std::to_string(seed), total_flux(maps->caustic) / maps->emitted);
    }
  }
}

// A source below the surface of a half space of glass: what leaves is ½∫_{cos θc}^1 (1 − F) dμ of its light,
// less than the critical cone (1 − cos θc)/2 = .1273.
TEST(HardCase, IsotropicSourceInGlass13) {
  HardCase c(13, "isotropic source inside glass, n = 1.5");
  Scene scene = empty_scene();
  Mesh walls = box({-1, -1, -1}, {1, 1, 0}, true);
  std::erase_if(walls.triangles, [&](const glm::uvec3& t) {
    return walls.positions[t.x].z + walls.positions[t.y].z + walls.positions[t.z].z == 0;
  });
  add_mesh(scene, walls, add_material(scene, lambert(Rgb(0))));
  add_mesh(scene, parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), add_material(scene, glass(1.5f)));
  add_point_light(scene, {0, 0, -0.5f}, Rgb(1));
  const auto room = prepared(std::move(scene));
  constexpr int kSteps = 100'000;
  double expected = 0;
  for (int i = 0; i < kSteps; ++i) expected += (1 - fresnel((i + 0.5) / kSteps, 1 / 1.5)) / (2 * kSteps);
  Quantity& escaped = c.equals("escaping share ½∫(1 − F)dμ", expected);
  Quantity& ledger = c.at_most("ledger's gap", 1e-6);
  for (const std::uint64_t seed : kSeeds) {
    Sample share;
    for (std::uint32_t pass = 0; pass < 20; ++pass) {
      const EnergyLedger e = shoot_maps(*room, 20'000, seed, pass)->ledger;
      share.add(e.escaped / e.emitted);
      ledger.add("seed " + std::to_string(seed),
                 std::abs((e.absorbed + e.escaped + e.truncated + e.rejected) / e.emitted - 1));
    }
    escaped.add("seed " + std::to_string(seed), share);
  }
  EXPECT_LT(expected, 0.1274);
}

// A beam of irradiance E₀ on a glass sphere (R = 1, n = 1.5). A ray at distance b from the axis, sin α = b, sin
// β = b/n, leaves the sphere at the angle γ = 2β − α beyond the axis' end with the slope of 2(α − β) towards
// the axis, and meets the plane at depth z at
//   x(b) = sin γ − tan 2(α − β)·(z − cos γ).
struct BallLens {
  double n = 1.5, z = 1.3;
  double x(double b) const {
    const double alpha = std::asin(b), beta = std::asin(b / n), gamma = 2 * beta - alpha;
    return std::sin(gamma) - std::tan(2 * (alpha - beta)) * (z - std::cos(gamma));
  }
  // Two transmissions.
  double transmitted(double b) const {
    const double t = 1 - fresnel(std::sqrt(1 - b * b), n);
    return t * t;
  }
  // E/E₀ at distance `at` from the axis: T² b|db|/(x|dx|) over all b with |x(b)| = at.
  double irradiance(double at) const {
    double sum = 0;
    for (int i = 0; i + 1 < kSteps; ++i) {
      const double b = (i + 0.5) / kSteps, next = (i + 1.5) / kSteps;
      const double x0 = std::abs(x(b)), x1 = std::abs(x(next));
      if ((x0 < at) != (x1 < at)) sum += transmitted(b) * b * (next - b) / (at * std::abs(x1 - x0));
    }
    return sum;
  }
  // The mean of the Epanechnikov estimate with radius r there: ∫∫ T² b db dφ K(|x(b, φ) − at|).
  double estimate(double at, double r) const {
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double b = (i + 0.5) / kSteps, from = std::abs(x(b));
      if (std::abs(from - at) >= r) continue;
      const double widest = std::acos(std::max(-1.0, (from * from + at * at - r * r) / (2 * from * at)));
      double ring = 0;
      for (int k = 0; k < 64; ++k) {
        const double d_sq = from * from + at * at - 2 * from * at * std::cos(widest * (k + 0.5) / 64);
        ring += 2 / kPiD * (1 - d_sq / (r * r)) / (r * r) / 64;
      }
      sum += transmitted(b) * b / kSteps * 2 * widest * ring;
    }
    return sum;
  }
  static constexpr int kSteps = 20'000;
};

// Estimates follow the kernel's mean over the analytic caustic, on both sides of its fold at x = .038, and away
// from the fold that mean's bias goes with r².
TEST(HardCaseStatistical, BallLens15) {
  HardCase c(15, "collimated beam on a glass sphere");
  Scene scene = empty_scene();
  // The plane at 1.3 lies between the sphere and its paraxial focus at 1.5.
  add_mesh(scene, sphere({0, 0, 0}, 1, 256), add_material(scene, glass(1.5f)));
  add_mesh(scene, parallelogram({-0.5f, -0.5f, -1.3f}, {1, 0, 0}, {0, 1, 0}),
           add_material(scene, lambert(Rgb(kDark))));
  PunctualLight sun;
  sun.type = LightType::directional;
  sun.intensity = Rgb(2);
  scene.lights.push_back(sun);
  const auto room = prepared(std::move(scene));
  const Ray ray{{0.1f, 0, -1.2f}, {0, 0, -1}};
  const SurfacePoint floor = make_surface(room->scene, ray, room->accel.intersect(ray));
  const Bsdf bsdf(room->scene, floor, {0, 0, 1});
  const BallLens lens;
  struct Place {
    double at, radius;
    Quantity* quantity;
    Sample seen;
  };
  std::vector<Place> places;
  for (const auto& [at, radius] :
       {std::pair(0.02, 0.012), {0.02, 0.006}, {0.02, 0.003}, {0.06, 0.008}, {0.1, 0.02}}) {
    char what[64];
    std::snprintf(what, sizeof what, "estimate at x = %g, r = %g, over E₀", at, radius);
    // Two and more internal reflections (F² = .16 %) reach the plane too, and .1 % comes back from it. The lens
    // of 256 rings focuses as one of facets: (π/256)² /8 of its radius off, .002 %.
    places.push_back({at, radius, &c.equals(what, lens.estimate(at, radius), {.relative = 0.003}), {}});
  }
  const double e = lens.irradiance(0.02);
  c.equals("that mean's bias at r = .006 over that at .003", 4, {.relative = 0.05})
      .add("quadrature", (lens.estimate(0.02, 0.006) - e) / (lens.estimate(0.02, 0.003) - e));
  for (const std::uint64_t seed : kSeeds) {
    for (Place& place : places) place.seen = {};
    for (std::uint32_t pass = 0; pass < 60; ++pass) {
      const auto maps = shoot_maps(*room, 100'000, seed, pass);
      for (Place& place : places) {
        // Sixteen places of the ring around the axis are alike.
        double sum = 0;
        for (int i = 0; i < 16; ++i) {
          SurfacePoint s = floor;
          const double phi = 2 * kPiD * i / 16;
          s.position = Vec3(place.at * std::cos(phi), place.at * std::sin(phi), -1.3);
          const auto r_sq = static_cast<float>(place.radius * place.radius);
          sum += static_cast<double>(test::estimate_radiance(maps->caustic, s, bsdf, kDiffuseLobe, r_sq).x) /
                 16;
        }
        place.seen.add(sum * kPiD / static_cast<double>(kDark) / maps->emitted / 2);
      }
    }
    for (Place& place : places) place.quantity->add("seed " + std::to_string(seed), place.seen);
  }
}

// A rod of 1 mm × 1 mm × 2 m: light at up to 30° to its axis is totally reflected a thousand times and leaves
// by the ends, where F reflects it again and again: 1/(1 + F) leaves by the far end.
TEST(HardCaseStatistical, GlassRod17) {
  HardCase c(17, "glass rod with a thousand total reflections");
  Scene scene = empty_scene();
  add_mesh(scene, box({-5e-4f, -5e-4f, -1}, {5e-4f, 5e-4f, 1}), add_material(scene, glass(1.5f)));
  // Everything that leaves by the far end lands on the plate beyond it.
  add_mesh(scene, parallelogram({-1, -1, 1.001f}, {2, 0, 0}, {0, 2, 0}), add_material(scene, lambert(Rgb(0))));
  scene.lights.push_back(
      spot_light({1e-5f, 2e-5f, -0.999f}, {0, 0, 1}, std::cos(0.5236f), std::cos(0.5237f), 1));
  const auto room = prepared(std::move(scene));
  constexpr int kSteps = 10'000;
  double far = 0;
  const double lowest = std::cos(0.5236);
  for (int i = 0; i < kSteps; ++i)
    far += 1 / (1 + fresnel(lowest + (1 - lowest) * (i + 0.5) / kSteps, 1 / 1.5)) / kSteps;
  // Between the cones of .5236 and .5237 rad lies .03 % of the light, at the steepest angles.
  Quantity& q = c.equals("share that leaves by the far end", far, {.relative = 3e-4});
  Quantity& lost = c.at_most("share truncated or rejected", 0);
  Quantity& bounces = c.at_most("500 over the mean number of reflections", 1);
  for (const std::uint64_t seed : kSeeds) {
    Sample share;
    double rays = 0;
    for (std::uint32_t pass = 0; pass < 20; ++pass) {
      const auto maps = shoot_maps(*room, 1000, seed, pass);
      const EnergyLedger& e = maps->ledger;
      // What roulette took and gave on long ways counts as absorbed, so the far end's share is what did not
      // escape.
      share.add(1 - e.escaped / e.emitted);
      lost.add("", (e.truncated + e.rejected) / e.emitted);
      rays += static_cast<double>(maps->rays) / 20'000;
    }
    q.add("seed " + std::to_string(seed), share);
    bounces.add("seed " + std::to_string(seed), 500 / rays);
  }
}

// From a point to a disk of .53° (the sun's width): the caustic of flat water is the same, E = T I/(h₁ +
// h₂/n)².
TEST(HardCaseStatistical, TinyLight25) {
  HardCase c(25, "caustic of flat water by lights of any size");
  const double n = static_cast<double>(1.33f);
  const double expected = (1 - (n - 1) * (n - 1) / ((n + 1) * (n + 1))) * 10 / std::pow(1 + 0.5 / n, 2);
  for (const float radius : {1e-6f, 1e-3f, 0.00462f}) {
    Scene scene = empty_scene();
    add_mesh(scene, parallelogram({-2, -2, -0.5f}, {4, 0, 0}, {0, 4, 0}),
             add_material(scene, lambert(Rgb(kDark))));
    add_mesh(scene, parallelogram({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}), add_material(scene, glass(1.33f)));
    add_mesh(
        scene, disk({0, 0, 1}, {0, 0, -1}, radius, 64),
        add_material(scene, emitter(Rgb(static_cast<float>(
                                10 / (64 * std::sin(kPiD / 64) * std::cos(kPiD / 64) * radius * radius))))));
    char what[48];
    std::snprintf(what, sizeof what, "E by a disk of radius %g m", static_cast<double>(radius));
    // cos⁵ of an emitter: 2.5 ρ²/d², ⟨ρ²⟩ = r²/3, at r = .1 m .4 %; .1 % from the floor.
    look_at_with(
        c.equals(what, expected, {.relative = 0.005, .precision = 0.025}), prepared(std::move(scene)),
        {.from = {0.2f, 0.1f, -0.2f}, .at = {0, 0, -0.5f}, .radius = 0.1f, .photons = 60'000, .passes = 50},
        photon_methods(), kPiD / static_cast<double>(kDark));
  }
}

// A floor of albedo a under a pane that mirrors continue to infinity, lit by the whole sky. By the reflections
// between its faces the pane transmits T = ∫ 2μ (1 − F)/(1 + F) dμ of diffuse light and reflects the rest, to
// the floor too: E = πLe·T/(1 − a(1 − T)). Paths find so large a light through glass easily.
TEST(HardCaseStatistical, SkyThroughAPane26) {
  HardCase c(26, "huge light through glass");
  Scene scene = empty_scene();
  scene.environment.radiance = Rgb(1);
  add_mesh(scene, parallelogram({-0.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0}),
           add_material(scene, lambert(Rgb(0.5f))));
  const std::uint32_t pane = add_material(scene, glass(1.5f));
  add_mesh(scene, parallelogram({-0.5f, -0.5f, 0.2f}, {1, 0, 0}, {0, 1, 0}), pane);
  add_mesh(scene, parallelogram({-0.5f, -0.5f, 0.1f}, {0, 1, 0}, {1, 0, 0}), pane);
  Mesh sides = box({-0.5f, -0.5f, 0}, {0.5f, 0.5f, 0.25f}, true);
  std::erase_if(sides.triangles, [&](const glm::uvec3& t) {
    return sides.positions[t.x].z == sides.positions[t.y].z && sides.positions[t.y].z == sides.positions[t.z].z;
  });
  add_mesh(scene, sides, add_material(scene, mirror(Rgb(1))));
  const auto room = prepared(std::move(scene));
  constexpr int kSteps = 100'000;
  double through = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double mu = (i + 0.5) / kSteps, f = fresnel(mu, 1.5);
    through += 2 * mu * (1 - f) / (1 + f) / kSteps;
  }
  look_at_with(
      c.equals("E/(πLe) = T/(1 − a(1 − T))", through / (1 - 0.5 * (1 - through)), {.precision = 0.025}), room,
      {.from = {0.1f, 0, 0.08f},
       .at = {0, 0.05f, 0},
       .radius = 0.1f,
       .photons = 20'000,
       .passes = 80,
       .side = 16},
      kMethods, 2);
}

}  // namespace
}  // namespace photond
