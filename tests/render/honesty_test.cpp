// What progressive pictures say of their own error against the truth.
#include <gtest/gtest.h>

#include <cmath>

#include "core/film/error.h"
#include "core/film/reconstruct.h"
#include "core/render/render.h"
#include "tests/render/hard_case.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

constexpr int kSide = 24;
constexpr int kSeeds = 20;

RenderTask task_of(const std::shared_ptr<const PreparedScene>& scene, const Camera& camera, Method method,
                   std::uint64_t seed) {
  PhotonSettings photons{.photons_per_pass = 10'000, .seed = seed};
  RenderSettings settings;
  settings.method = method;
  settings.width = settings.height = kSide;
  settings.seed = seed;
  auto task = make_render_task(scene, camera, photons, settings, test::workers().execution());
  EXPECT_TRUE(task.ok());
  return *task;
}

Film render(const RenderTask& task, std::uint32_t passes) {
  Film film(kSide, kSide);
  const MapSource maps = [&](const MapKey& key, const Execution& e) { return build_photon_maps(*task.scene, key, e); };
  for (std::uint32_t pass = 0; pass < passes; ++pass) {
    add_pass(film, pass, *render_pass(task, pass, maps, test::workers().execution()));
  }
  return film;
}

/// Over kSeeds pictures.
struct Honesty {
  double covered = 0;     ///< share of pixels and channels within their bound
  double predicted = 0;   ///< mean square error over the picture
  double truth = 0;
};

Honesty measure(const std::shared_ptr<const PreparedScene>& scene, const Camera& camera, const Image& reference,
                int seeds, std::uint32_t passes) {
  Honesty result;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Film film = render(task_of(scene, camera, Method::progressive, static_cast<std::uint64_t>(seed)), passes);
    const Image picture = film_picture(film);
    const ErrorLayers layers = error_layers(film);
    const ErrorEstimate error = estimate_error(film);
    result.predicted += error.rmse * error.rmse / seeds;
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        const float off = picture.pixels[i][c] - reference.pixels[i][c];
        result.covered += std::abs(off) <= layers.bound.pixels[i][c];
        result.truth += static_cast<double>(off) * static_cast<double>(off);
      }
    }
  }
  const double count = 3.0 * kSide * kSide * seeds;
  result.covered /= count;
  result.truth /= count;
  return result;
}

/// Enters it as case 38.
void judge(const Honesty& found, const std::string& where, const test::Tolerance& covered, const test::Tolerance& predicted) {
  test::HardCase c(38, "error bound coverage");
  const std::string seeds = std::to_string(kSeeds) + " seeds";
  c.equals("share of pixels within their 95 % bound, " + where, 0.95, covered).add(seeds, found.covered);
  c.equals("predicted over true mean square error, " + where, 1, predicted).add(seeds, found.predicted / found.truth);
}

Image constant(double value) {
  Image image(kSide, kSide);
  for (Rgb& pixel : image.pixels) pixel = Rgb(static_cast<float>(value));
  return image;
}

TEST(HardCaseStatistical, CoverageInAFurnace38) {
  Scene scene = test::empty_scene();
  Material wall = test::emitter(Rgb(1));
  wall.base_color = Rgb(0.5f);
  test::add_mesh(scene, test::box({-1, -1, -1}, {1, 1, 1}, true), test::add_material(scene, wall));
  const Camera camera = look_at({0.8f, 0.7f, 0.6f}, {-1, 0.1f, 0.1f}, {0, 0, 1}, 0.6f);
  const Honesty found = measure(test::prepared(std::move(scene)), camera, constant(2), kSeeds, 64);
  // What is promised. A wall's direct light is half of it: no bias, and tails that four blocks know little of.
  judge(found, "in a closed furnace", {.absolute = 0.02}, {.absolute = 0.2});
}

/// A point light at the center of a glass shell that loses nothing: L = ρ/π·I h/(h² + x²)^{3/2}.
TEST(HardCaseStatistical, CoverageUnderAGlassShell38) {
  Scene scene = test::empty_scene();
  const std::uint32_t glass = test::add_material(scene, test::glass(1.5f));
  test::add_mesh(scene, test::sphere({0, 0, 1}, 0.5f, 64), glass);
  test::add_mesh(scene, test::inside_out(test::sphere({0, 0, 1}, 0.4f, 64)), glass);
  test::add_mesh(scene, test::parallelogram({-3, -3, -1}, {6, 0, 0}, {0, 6, 0}),
                 test::add_material(scene, test::lambert(Rgb(0.5f))));
  test::add_point_light(scene, {0, 0, 1}, Rgb(10));
  Camera camera = look_at({0, 0, 0.4f}, {0, 0, -1}, {0, 1, 0}, 1.6f);
  const auto prepared = test::prepared(std::move(scene));
  Image reference(kSide, kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      double sum = 0;
      for (int n = 0; n < 64; ++n) {
        const Vec2 film((static_cast<float>(x) + (n % 8 + 0.5f) / 8) / kSide, (static_cast<float>(y) + (n / 8 + 0.5f) / 8) / kSide);
        const Ray ray = camera_ray(camera, film, 1);
        const Vec3 at = ray.origin + ray.direction * ((-1 - ray.origin.z) / ray.direction.z);
        sum += 10 * 2 / std::pow(4.0 + at.x * at.x + at.y * at.y, 1.5) * 0.5 / std::numbers::pi / 64;
      }
      reference.at(x, y) = Rgb(static_cast<float>(sum));
    }
  }
  const Honesty found = measure(prepared, camera, reference, kSeeds, 64);
  judge(found, "under a glass shell", {.absolute = 0.02}, {.absolute = 0.2});   // what is promised
}

/// Against a long run of the path tracer.
TEST(HardCaseStatistical, CoverageInARoom38) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::box({-1, -1, -1}, {1, 1, 1}, true), test::add_material(scene, test::lambert({0.7f, 0.6f, 0.5f})));
  test::add_mesh(scene, test::box({-0.6f, -0.2f, -1}, {-0.1f, 0.3f, -0.2f}), test::add_material(scene, test::lambert({0.7f, 0.2f, 0.2f})));
  test::add_mesh(scene, test::parallelogram({-0.3f, -0.3f, 0.98f}, {0, 0.6f, 0}, {0.6f, 0, 0}),
                 test::add_material(scene, test::emitter(Rgb(8))));
  const Camera camera = look_at({0.2f, -0.95f, 0.2f}, {0, 1, -0.3f}, {0, 0, 1}, 1.2f);
  const auto prepared = test::prepared(std::move(scene));
  const Image reference = film_picture(render(task_of(prepared, camera, Method::path, 99), 20'000));
  const Honesty found = measure(prepared, camera, reference, kSeeds, 64);
  judge(found, "in a room with a box", {.absolute = 0.02}, {.absolute = 0.2});   // what is promised
}

}  // namespace
}  // namespace photond
