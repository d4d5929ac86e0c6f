#include "core/render/pilot.h"

#include <gtest/gtest.h>

#include "core/render/render.h"
#include "server/cli/load_scene.h"
#include "tests/support/scene_files.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

using namespace test;

// A view of a box on a square floor of this many metres, under a light of a quarter of them.
std::shared_ptr<const PreparedScene> box_on_a_floor(float size) {
  Scene scene = empty_scene();
  const std::uint32_t grey = add_material(scene, lambert(Rgb(0.6f)));
  add_mesh(scene, parallelogram({-size / 2, -size / 2, 0}, {size, 0, 0}, {0, size, 0}), grey);
  add_mesh(scene, box({-0.5f, -0.5f, 0}, {0.5f, 0.5f, 1}), grey);
  const float lamp = size / 4;
  add_mesh(scene, parallelogram({-lamp / 2, -lamp / 2, size / 4}, {0, lamp, 0}, {lamp, 0, 0}),
           add_material(scene, emitter(Rgb(1))));
  return prepared(std::move(scene));
}

Camera camera() { return look_at({3, 2, 2}, {0, 0, 0.4f}, {0, 0, 1}, 0.7f); }

Result<RenderTask> task_of(const std::shared_ptr<const PreparedScene>& scene, Method method) {
  RenderSettings settings;
  settings.method = method;
  settings.width = settings.height = 48;
  return make_render_task(scene, camera(), {50'000, 1}, settings, workers().execution());
}

TEST(Pilot, ChoosesPhotonsWhereTheyAreDense) {
  const auto task = task_of(box_on_a_floor(8), Method::automatic);
  ASSERT_TRUE(task.ok());
  EXPECT_EQ(task->plan.method, Method::progressive);
}

TEST(Pilot, ChoosesPathsWherePhotonsAreSparse) {
  const auto task = task_of(box_on_a_floor(2000), Method::automatic);
  ASSERT_TRUE(task.ok());
  EXPECT_EQ(task->plan.method, Method::hybrid);
  EXPECT_FALSE(task->plan.uses_maps) << "nothing bundles light";
  EXPECT_EQ(task->guide, nullptr) << "no photons, no guide";
}

/// Bright paths through a door ajar are rare: eight through a pixel of the pilot miss nearly all of them, in pictures of
/// 256 × 256 pixels.
TEST(Pilot, IsNotMisledByPathsThatAreRarelyBright) {
  const auto folder = shared_scenes();
  if (!folder) GTEST_SKIP() << "no shared scenes (set PHOTOND_SCENES)";
  auto scene = load_scene(*folder / "gi" / "ajar.glb");
  ASSERT_TRUE(scene.ok());
  const Camera main = scene->cameras.at(0);
  const std::shared_ptr<const PreparedScene> ajar = prepared(*std::move(scene));
  for (const int size : {128, 256, 512}) {
    RenderSettings settings;
    settings.width = settings.height = size;
    const auto task = make_render_task(ajar, main, {}, settings, workers().execution());
    ASSERT_TRUE(task.ok());
    EXPECT_EQ(task->plan.method, Method::progressive) << size;
  }
}

// Relative variance of one pass, on average over the picture.
double measured(const RenderTask& task, int passes) {
  const MapSource maps = [&](const MapKey& key, const Execution& e) { return build_photon_maps(*task.scene, key, e); };
  std::vector<Sample> pixels(48 * 48);
  double mean = 0;
  for (int pass = 0; pass < passes; ++pass) {
    RenderTask other = task;   // the radius of the first pass
    other.settings.seed = other.photons.seed = static_cast<std::uint64_t>(pass);
    const auto image = render_pass(other, 0, maps, workers().execution());
    EXPECT_TRUE(image.ok());
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i].add(static_cast<double>(image->radiance.pixels[i].x));
  }
  for (const Sample& pixel : pixels) mean += pixel.mean / static_cast<double>(pixels.size());
  double noise = 0;
  for (const Sample& pixel : pixels) {
    const double variance = pixel.standard_error() * pixel.standard_error() * passes;
    noise += variance / (pixel.mean * pixel.mean + 0.01 * mean * mean) / static_cast<double>(pixels.size());
  }
  return noise;
}

// The noise that the pilot expects is that of passes, but for the luck of eight samples, and for edges, where passes see
// aliasing and photons of less than a kernel: within a factor of three.
TEST(PilotStatistical, TellsTheNoiseOfPasses) {
  const double factor = std::log2(3);
  for (const float size : {8.0f, 30.0f, 90.0f}) {
    const auto scene = box_on_a_floor(size);
    const auto photons = task_of(scene, Method::progressive);
    const auto paths = task_of(scene, Method::path);
    ASSERT_TRUE(photons.ok() && paths.ok());
    RadianceSettings settings;
    settings.pixel_spread = pixel_spread(camera(), 48);
    const PilotNoise noise = measure_noise(*scene, camera(), 1, settings, *photons->guide, kFewPilotPaths, workers().execution());
    const double by_photons = measured(*photons, 60), by_paths = measured(*paths, 60);
    EXPECT_LT(std::abs(std::log2(noise.photons / by_photons)), factor) << size << ": " << noise.photons << " for " << by_photons;
    EXPECT_LT(std::abs(std::log2(noise.paths / by_paths)), factor) << size << ": " << noise.paths << " for " << by_paths;
  }
}

}  // namespace
}  // namespace photond
