// Glass that bends each colour by its own index.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/render/look.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

using namespace test;

constexpr float kIor = 1.6f;
constexpr float kAbbe = 10;   // stronger than any real glass: colours part clearly

Material dispersive() {
  Material m = glass(kIor);
  m.dispersion = 20 / kAbbe;
  return m;
}

double bump(double w, double height, double middle, double below, double above) {
  const double t = (w - middle) / (w < middle ? below : above);
  return height * std::exp(-t * t / 2);
}

// How far a beam at 60° moves along the floor within a metre of glass, on average over the wavelengths that a channel of
// sRGB sees: sums over the observer's curves in steps of a tenth of a nanometre, with Cauchy's n(λ) = a + b/λ².
double mean_way(int channel) {
  const double n = static_cast<double>(kIor), sine = std::sqrt(0.75);
  const double b = (n - 1) / static_cast<double>(kAbbe) / (std::pow(486.13, -2) - std::pow(656.27, -2));
  const double a = n - b / (587.56 * 587.56);
  static constexpr double kRows[3][3] = {
      {3.2406, -1.5372, -0.4986}, {-0.9689, 1.8758, 0.0415}, {0.0557, -0.2040, 1.0570}};
  double sum = 0, weight = 0;
  for (double w = 380; w < 720; w += 0.1) {
    const double x =
        bump(w, 1.056, 599.8, 37.9, 31) + bump(w, 0.362, 442, 16, 26.7) + bump(w, -0.065, 501.1, 20.4, 26.2);
    const double y = bump(w, 0.821, 568.8, 46.9, 40.5) + bump(w, 0.286, 530.9, 16.3, 31.1);
    const double z = bump(w, 1.217, 437, 11.8, 36) + bump(w, 0.681, 459, 26, 13.8);
    const double seen = std::max(0.0, kRows[channel][0] * x + kRows[channel][1] * y + kRows[channel][2] * z);
    const double index = a + b / (w * w);
    sum += seen * sine / std::sqrt(index * index - sine * sine);
    weight += seen;
  }
  return sum / weight;
}

// A white beam falls at 60° through a metre of glass between two metres of air. Where its photons land on average tells
// the index of each channel. What is reflected within the glass lands more than a metre further.
TEST(HardCase, DispersiveSlab11) {
  HardCase c(11, "white beam through a slab that disperses");
  Scene scene = empty_scene();
  add_mesh(scene, box({-4, -4, 0}, {8, 4, 1}), add_material(scene, dispersive()));
  add_mesh(scene, parallelogram({-4, -4, -1}, {12, 0, 0}, {0, 8, 0}), add_material(scene, lambert(Rgb(1e-3f))));
  const double tangent = std::sqrt(3.0), sine = std::sqrt(0.75);
  scene.lights.push_back(
      spot_light({0, 0, 2}, {static_cast<float>(sine), 0, -0.5f}, 0.999999f, 0.999998f, 1));
  const auto room = prepared(std::move(scene));
  constexpr std::uint32_t kPasses = 200;
  static constexpr const char* kNames[] = {"red", "green", "blue"};
  for (int channel = 0; channel < 3; ++channel) {
    // Two hundred wavelengths stand for a spectrum: with these seeds their mean way lies up to .04 % off.
    Quantity& way = c.equals(std::string("way of ") + kNames[channel] + " in the glass", mean_way(channel),
                             {.relative = 0.0005, .precision = 0.005});
    for (const std::uint64_t seed : kSeeds) {
      Sample seen;
      for (std::uint32_t pass = 0; pass < kPasses; ++pass) {
        const auto maps = shoot_maps(*room, 2000, seed, pass);
        double sum = 0, flux = 0;
        for (std::uint32_t i = 0; i < maps->caustic.size(); ++i) {
          const double x = static_cast<double>(maps->caustic.position(i).x) - 2 * tangent;
          const auto power = static_cast<double>(maps->caustic.flux(i)[channel]);
          if (std::abs(x - 0.65) > 0.5) continue;
          sum += power * x;
          flux += power;
        }
        ASSERT_GT(flux, 0);
        seen.add(sum / flux);
      }
      way.add("seed " + std::to_string(seed), seen);
    }
  }
}

// Where all is light, glass is not seen, in any channel.
TEST(HardCase, DispersiveFurnace23) {
  HardCase c(23, "glass that disperses in a furnace");
  Scene scene = empty_scene();
  add_mesh(scene, sphere({0, 0, 0}, 1, 64), add_material(scene, dispersive()));
  add_mesh(scene, box({-3, -3, -3}, {3, 3, 3}, true), add_material(scene, emitter(Rgb(1))));
  const auto room = prepared(std::move(scene));
  const Look look{.from = {0.1f, -2.5f, 0.2f}, .at = {0.3f, 0, 0.5f}, .photons = 1000, .passes = 200};
  for (int channel = 0; channel < 3; ++channel) {
    look_at_with(c.equals("L of channel " + std::to_string(channel), 1, {.relative = 0.002, .precision = 0.03}), room,
                 look, {Method::path, Method::hybrid}, 1, channel);
  }
}

// A floor seen through the glass that lights it: photons and paths that meet there are of the same wavelengths.
TEST(Dispersion, PathsAndPhotonsMeetInTheSameWavelengths) {
  Scene scene = empty_scene();
  add_mesh(scene, sphere({0, 0, 1}, 0.8f, 64), add_material(scene, dispersive()));
  add_mesh(scene, parallelogram({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}), add_material(scene, lambert(Rgb(0.6f))));
  add_mesh(scene, parallelogram({-1, -1, 5}, {0, 2, 0}, {2, 0, 0}), add_material(scene, emitter(Rgb(10))));
  const auto room = prepared(std::move(scene));
  const Look look{.from = {0.2f, 0.1f, 4}, .at = {0.05f, 0.02f, 1}, .radius = 0.02f, .passes = 200, .side = 8};
  const auto paths = see(room, Method::path, 3, look);
  for (const Method method : {Method::progressive, Method::hybrid}) {
    const auto seen = see(room, method, 1, look);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const double error = std::hypot(paths[channel].standard_error(), seen[channel].standard_error());
      EXPECT_NEAR(seen[channel].mean, paths[channel].mean, 0.005 * paths[channel].mean + kSigmas * error)
          << method_name(method) << channel;   // .5 %: the kernel
      EXPECT_LT(error, 0.1 * paths[channel].mean);
    }
  }
}

}  // namespace
}  // namespace photond
