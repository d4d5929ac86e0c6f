#include "tests/render/look.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/scenes.h"

namespace photond::test {

std::vector<Method> photon_methods() {
  std::vector<Method> methods = kMethods;
  std::erase(methods, Method::path);
  return methods;
}

std::string run_name(Method method, std::uint64_t seed) {
  return std::string(method_name(method)) + ", seed " + std::to_string(seed);
}

std::array<Sample, 3> see(const std::shared_ptr<const PreparedScene>& scene, Method method, std::uint64_t seed,
                          const Look& look) {
  const Vec3 view = glm::normalize(look.at - look.from);
  const Vec3 up = std::abs(view.z) < 0.9f ? Vec3(0, 0, 1) : Vec3(1, 0, 0);
  RenderSettings settings;
  settings.method = method;
  settings.width = settings.height = look.side;
  settings.radius = look.radius;
  settings.max_depth = look.max_depth;
  PhotonSettings photons;
  photons.photons_per_pass = look.photons;
  const Execution& execution = workers().execution();
  // A ten-thousandth of a radian: millimetres apart at ten metres.
  auto task =
      make_render_task(scene, photond::look_at(look.from, look.at, up, 1e-4f), photons, settings, execution);
  EXPECT_TRUE(task.ok());
  const MapSource maps = [&](const MapKey& key, const Execution& e) {
    return build_photon_maps(*scene, key, e);
  };
  std::array<Sample, 3> samples;
  for (int pass = 0; pass < look.passes; ++pass) {
    task->settings.seed = task->photons.seed = seed << 32 | static_cast<std::uint64_t>(pass);
    const auto image = render_pass(*task, 0, maps, execution);
    EXPECT_TRUE(image.ok());
    glm::dvec3 sum(0);
    for (const Rgb& pixel : image->radiance.pixels) sum += glm::dvec3(pixel);
    for (int c = 0; c < 3; ++c) samples[static_cast<std::size_t>(c)].add(sum[c] / (look.side * look.side));
  }
  return samples;
}

void look_at_with(Quantity& quantity, const std::shared_ptr<const PreparedScene>& scene, const Look& look,
                  const std::vector<Method>& methods, double scale, int channel) {
  for (const Method method : methods) {
    for (const std::uint64_t seed : kSeeds) {
      const auto samples = see(scene, method, seed, look);
      quantity.add(run_name(method, seed), scaled(samples[static_cast<std::size_t>(channel)], scale));
    }
  }
}

Sample scaled(Sample sample, double factor) {
  sample.mean *= factor;
  sample.m2 *= factor * factor;
  return sample;
}

std::shared_ptr<const PhotonMaps> shoot_maps(const PreparedScene& scene, std::uint32_t photons,
                                             std::uint64_t seed, std::uint32_t pass) {
  auto maps = build_photon_maps(scene, {scene.digest, {photons, seed}, pass}, workers().execution());
  EXPECT_TRUE(maps.ok());
  return *maps;
}

double total_flux(const PhotonMap& map) {
  double sum = 0;
  for (std::uint32_t i = 0; i < map.size(); ++i) sum += static_cast<double>(map.flux(i).x);
  return sum;
}

Measured by_paths(const std::shared_ptr<const PreparedScene>& room, const Look& look) {
  const Sample one = see(room, Method::path, 3, look)[0];
  const Sample two = see(room, Method::path, 4, look)[0];
  return {(one.mean + two.mean) / 2, std::hypot(one.standard_error(), two.standard_error()) / 2};
}

}  // namespace photond::test
