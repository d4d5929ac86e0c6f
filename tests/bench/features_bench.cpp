// Times a scene of Lambert surfaces and one lamp. Built twice: as photond is, and with all other features compiled out.
#include <cstdio>
#include <cstdlib>

#include "core/film/film.h"
#include "core/photon/shoot.h"
#include "core/render/render.h"
#include "tests/bench/bench.h"
#include "tests/support/scenes.h"

namespace photond::bench {
namespace {

// A room with two boxes.
std::shared_ptr<const PreparedScene> room() {
  Scene scene = test::empty_scene();
  const auto white = test::add_material(scene, test::lambert(Rgb(0.7f)));
  const auto red = test::add_material(scene, test::lambert({0.6f, 0.1f, 0.1f}));
  test::add_mesh(scene, test::box({-1, -1, 0}, {1, 1, 2}, true), white);
  test::add_mesh(scene, test::box({-0.7f, -0.2f, 0}, {-0.1f, 0.4f, 1.2f}), red);
  test::add_mesh(scene, test::box({0.1f, -0.6f, 0}, {0.6f, 0, 0.6f}), white);
  test::add_mesh(scene, test::parallelogram({-0.3f, -0.3f, 1.98f}, {0, 0.6f, 0}, {0.6f, 0, 0}),
                 test::add_material(scene, test::emitter(Rgb(8))));
  return test::prepared(std::move(scene));
}

double pass_seconds(const std::shared_ptr<const PreparedScene>& scene, Method method, const Execution& execution) {
  RenderSettings settings;
  settings.method = method;
  settings.width = settings.height = 256;
  const Camera camera = look_at({0, -0.95f, 1}, {0, 1, -0.1f}, {0, 0, 1}, 1.2f);
  const auto task = make_render_task(scene, camera, {}, settings, execution);
  if (!task) std::exit(1);
  const MapSource maps = [&](const MapKey& key, const Execution& e) { return build_photon_maps(*scene, key, e); };
  return seconds([&] {
    for (std::uint32_t pass = 0; pass < 2; ++pass) {
      if (!render_pass(*task, pass, maps, execution)) std::exit(1);
    }
  });
}

double shoot_seconds(const PreparedScene& scene, const Execution& execution) {
  return seconds([&] {
    parallel_for(execution, 256, 1, [&](std::size_t i) { shoot(scene, {scene.digest, {}, 0}, i * 2048, (i + 1) * 2048); });
  });
}

}  // namespace
}  // namespace photond::bench

int main() {
  using namespace photond;
  using namespace photond::bench;
  const Workers workers(0);
  const Execution execution = workers.execution();
  const auto scene = room();
  const auto print = [](const char* name, const auto& work) {
    (void)work();   // caches, clocks, the system's pages
    std::printf("%s %.6f\n", name, work());
  };
  print("photons", [&] { return shoot_seconds(*scene, execution); });
  print("path", [&] { return pass_seconds(scene, Method::path, execution); });
  print("progressive", [&] { return pass_seconds(scene, Method::progressive, execution); });
  return 0;
}
