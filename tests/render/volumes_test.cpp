// Light, surfaces and camera within a volume that absorbs.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/look.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

using namespace test;

// A floor below a lamp, all in a liquid that halves light in a metre and refracts none.
TEST(Volumes, AbsorbWhatStaysWithinThem) {
  Scene scene = empty_scene();
  Material liquid = glass(1);
  liquid.attenuation_color = Rgb(0.5f);
  liquid.attenuation_distance = 1;
  add_mesh(scene, box({-4, -1, -4}, {4, 4, 4}), add_material(scene, liquid));
  add_mesh(scene, parallelogram({-2, 0, -2}, {0, 0, 4}, {4, 0, 0}), add_material(scene, lambert(Rgb(0.5f))));
  add_point_light(scene, {0, 2, 0}, Rgb(10));
  const auto room = prepared(std::move(scene));
  const double irradiance = 10 / 4.0 * 0.25;
  for (const Vec3& from : {Vec3(0.5f, 1.5f, 0.5f), Vec3(1, 3, 1), Vec3(2, 6, 2)}) {
    // The last of them is outside: two thirds of its way are in the liquid.
    const double within = static_cast<double>(glm::length(from)) * (from.y > 4 ? 4.0 / 6 : 1.0);
    const double expected = 0.5 / static_cast<double>(kPi) * irradiance * std::exp2(-within);
    for (const Method method : kMethods) {
      const Sample seen = see(room, method, 1, {.from = from, .at = {0, 0, 0}, .radius = 0.1f})[0];
      // Across the kernel the irradiance falls by .4 %.
      EXPECT_NEAR(seen.mean, expected, 0.005 * expected + kSigmas * seen.standard_error()) << method_name(method) << from.y;
    }
  }
}

}  // namespace
}  // namespace photond
