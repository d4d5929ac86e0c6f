// Light by way of mirrors, where the way can be unfolded, and by every method.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/render/look.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

using namespace test;

constexpr double kPiD = std::numbers::pi;
// So dark a floor that what it sends into the scene and back is at most a thousandth of what arrives.
constexpr float kDark = 1e-3f;

// A light at (0,0,1) beside the mirror x = 2 is seen from (1,0,0) at (4,0,1) too: E = m I cos/d² of the virtual
// one.
TEST(HardCase, PlanarMirrorPointLight10) {
  HardCase c(10, "planar mirror");
  Scene scene = empty_scene();
  add_mesh(scene, parallelogram({-3, -3, 0}, {5, 0, 0}, {0, 6, 0}), add_material(scene, lambert(Rgb(0.5f))));
  add_mesh(scene, parallelogram({2, -3, 0}, {0, 0, 3}, {0, 6, 0}), add_material(scene, mirror(Rgb(0.9f))));
  // A spot towards the mirror image of (1,0,0), which is (3,0,0); nothing arrives directly.
  scene.lights.push_back(spot_light({0, 0, 1}, {3, 0, -1}, 0.99f, 0.98f, 10));
  const auto room = prepared(std::move(scene));
  // E'' of cos/d² at distance 3.2 over a kernel with ⟨ρ²⟩ = r²/3: below (r/d)² = .1 %.
  look_at_with(c.equals("E = m I cos/d² of the virtual point light", 9 / std::pow(10, 1.5),
                        {.relative = 0.001, .precision = 0.025}),
               room, {.from = {1, 0.5f, 1}, .at = {1, 0, 0}, .photons = 10'000, .passes = 80}, photon_methods(),
               kPiD / 0.5);
}

// A square that looks at the mirror x = 2, above a floor that it lights by way of the mirror only where one
// stands behind it.
std::shared_ptr<const PreparedScene> square_before_a_mirror(float roughness) {
  Scene scene = empty_scene();
  add_mesh(scene, parallelogram({-3, -3, 0}, {5, 0, 0}, {0, 6, 0}), add_material(scene, lambert(Rgb(kDark))));
  Material metal = mirror(Rgb(0.9f));
  metal.roughness = roughness;
  add_mesh(scene, parallelogram({2, -3, 0}, {0, 0, 3}, {0, 6, 0}), add_material(scene, metal));
  add_mesh(scene, parallelogram({1.5f, -0.5f, 0.3f}, {0, 1, 0}, {0, 0, 0.9f}),
           add_material(scene, emitter(Rgb(5))));
  return prepared(std::move(scene));
}
const Look kBehindTheSquare{
    .from = {1, 0.5f, 1}, .at = {1.2f, 0, 0}, .photons = 60'000, .passes = 50, .side = 48};

// The same with an area light, which paths find too: the mirrored scene equals the unfolded one.
TEST(HardCaseStatistical, PlanarMirrorAreaLight10) {
  HardCase c(10, "planar mirror");
  // The image of the mirrored square.
  Scene scene = empty_scene();
  add_mesh(scene, parallelogram({-3, -3, 0}, {5, 0, 0}, {0, 6, 0}), add_material(scene, lambert(Rgb(kDark))));
  add_mesh(scene, parallelogram({2.5f, -0.5f, 0.3f}, {0, 0, 0.9f}, {0, 1, 0}),
           add_material(scene, emitter(Rgb(0.9f * 5))));
  const Measured unfolded = by_paths(prepared(std::move(scene)), kBehindTheSquare);
  // The kernel's bias is below (r/d)²/3 = .15 %.
  look_at_with(c.equals("L with the mirror, against the unfolded scene", unfolded.mean,
                        {.relative = 0.002, .absolute = 4 * unfolded.error, .precision = 0.025}),
               square_before_a_mirror(0), kBehindTheSquare);
}

// What leaves one focus of an ellipsoid of mirror goes through the other: a small target there receives mΦ of
// all that did not meet it on the way.
TEST(HardCaseStatistical, EllipsoidMirror16) {
  HardCase c(16, "ellipsoid mirror from focus to focus");
  constexpr float kRadius = 0.05f;
  Scene scene = empty_scene();
  Mesh shell = sphere({0, 0, 0}, 1, 256);
  for (std::size_t i = 0; i < shell.positions.size(); ++i) {
    shell.positions[i] *= Vec3(0.8f, 0.8f, 1);
    shell.normals[i] = glm::normalize(shell.normals[i] / Vec3(0.8f, 0.8f, 1));
  }
  add_mesh(scene, inside_out(shell), add_material(scene, mirror(Rgb(0.9f))));
  add_mesh(scene, sphere({0, 0, 0.6f}, kRadius, 64), add_material(scene, lambert(Rgb(kDark))));
  add_point_light(scene, {0, 0, -0.6f}, Rgb(1));
  const auto room = prepared(std::move(scene));
  const double direct = (1 - std::sqrt(1 - std::pow(static_cast<double>(kRadius) / 1.2, 2))) / 2;
  // The target is a polyhedron, smaller by (π/64)²/6 = .04 % of its radius: some rays of the direct ones pass
  // (10⁻⁷). A thousandth is scattered by the target and comes back in part.
  Quantity& q = c.equals("flux on the target over mΦ of what missed it", 1, {.relative = 0.001});
  for (const std::uint64_t seed : kSeeds) {
    Sample share;
    for (std::uint32_t pass = 0; pass < 10; ++pass) {
      const auto maps = shoot_maps(*room, 20'000, seed, pass);
      share.add(total_flux(maps->caustic) / maps->emitted /
                (4 * kPiD * static_cast<double>(0.9f) * (1 - direct)));
    }
    q.add("seed " + std::to_string(seed), share);
  }
}

// A caster from smooth to rough: at every roughness photons and paths agree, on both sides of the thresholds at
// which a lobe counts as a mirror (α = 10⁻⁴) and as a place to gather at (α = .25).
TEST(HardCaseStatistical, RoughnessSweep34) {
  HardCase c(34, "light by way of a mirror of any roughness");
  double last = 0;
  for (const float roughness : {0.0f, 0.0099f, 0.0101f, 0.1f, 0.3f, 0.499f, 0.501f}) {
    const auto room = square_before_a_mirror(roughness);
    const auto [expected, error] = by_paths(room, kBehindTheSquare);
    char what[64];
    std::snprintf(what, sizeof what, "L at roughness %g, by paths of other seeds",
                  static_cast<double>(roughness));
    // The reference's own noise, and (r/d)²/3 = .15 % of the kernel.
    look_at_with(c.equals(what, expected, {.relative = 0.002, .absolute = 4 * error, .precision = 0.03}), room,
                 kBehindTheSquare);
    if (roughness == 0.0101f || roughness == 0.501f) {
      // Over 2·10⁻⁴ or .002 of roughness the lobe widens by that fraction of itself.
      c.equals("step across the threshold before it, relative", 0,
               {.absolute = 0.01 + 4 * 1.5 * error / expected})
          .add("path", expected / last - 1);
    }
    last = expected;
  }
}

// A room with a mirror and a glass ball, seen by every method: what one counts twice or leaves out shows.
TEST(HardCaseStatistical, MapsOnAndOff35) {
  HardCase c(35, "photon map on and off");
  Scene scene = empty_scene();
  add_mesh(scene, box({-2, -2, 0}, {2, 2, 3}, true), add_material(scene, lambert(Rgb(0.6f))));
  add_mesh(scene, parallelogram({-1, -1.5f, 0.5f}, {2, 0, 0}, {0, 0, 1.5f}),
           add_material(scene, mirror(Rgb(0.9f))));
  add_mesh(scene, sphere({-1, 0.5f, 0.6f}, 0.5f), add_material(scene, glass(1.5f)));
  add_mesh(scene, parallelogram({-0.5f, 0, 2.9f}, {0, 1, 0}, {1, 0, 0}), add_material(scene, emitter(Rgb(5))));
  const auto room = prepared(std::move(scene));
  const Look look{
      .from = {0, 1, 1}, .at = {0.5f, -0.2f, 0}, .radius = 0.1f, .photons = 50'000, .passes = 80, .side = 40};
  const auto [expected, error] = by_paths(room, look);
  std::vector<Method> exact = kMethods;
  std::erase(exact, Method::photon_map);
  // The reference's own noise, and the kernel's bias in a field that bends on the scale of a metre: (r/L)²/3.
  look_at_with(c.equals("L, by paths of other seeds", expected,
                        {.relative = 0.0035, .absolute = 4 * error, .precision = 0.015}),
               room, look, exact);
  // Gather rays end in corners, beside edges of the mirror and on the ball: half the light is indirect, some 3
  // % of its ends lie in a strip where a fifth is missing, and caustics among them are blurred.
  look_at_with(c.equals("the same by final gather", expected, {.relative = 0.02, .absolute = 4 * error}), room,
               look, {Method::photon_map});
}

}  // namespace
}  // namespace photond
