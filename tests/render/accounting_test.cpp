// What is counted: flux, passes, bits.
#include <gtest/gtest.h>

#include <numbers>

#include <tbb/global_control.h>

#include "core/film/film.h"
#include "core/film/reconstruct.h"
#include "core/photon/shoot.h"
#include "tests/render/look.h"
#include "tests/support/estimate.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

using namespace test;

RenderTask task_of(const std::shared_ptr<const PreparedScene>& room, Method method) {
  RenderSettings settings;
  settings.method = method;
  settings.width = 24;
  settings.height = 16;
  const auto task =
      make_render_task(room, room->scene.cameras[0], {10'000, 5}, settings, workers().execution());
  EXPECT_TRUE(task.ok());
  return *task;
}

PassImage pass_of(const RenderTask& task, std::uint32_t pass, const Execution& execution) {
  const MapSource maps = [&](const MapKey& key, const Execution& e) {
    return build_photon_maps(*task.scene, key, e);
  };
  return *render_pass(task, pass, maps, execution);
}

TEST(HardCase, BitsOfPasses36) {
  HardCase c(36, "the same bits for any threads and any split of the passes");
  // TBB lends no more threads than there are cores, unless it is told.
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
  const auto room = busy_room();
  for (const Method method : kMethods) {
    Quantity& threads =
        c.equals(std::string("pixels that differ with 2 and 8 threads, ") + method_name(method), 0);
    Quantity& split = c.equals(
        std::string("pixels that differ when passes 3, 2 and 0, 1 are merged, ") + method_name(method), 0);
    const RenderTask task = task_of(room, method);
    std::vector<PassImage> once;
    for (std::uint32_t pass = 0; pass < 4; ++pass) once.push_back(pass_of(task, pass, Execution{}));
    for (const int count : {2, 8}) {
      const Workers many(count);
      const PassImage image = pass_of(task, 1, many.execution());
      double differ = 0;
      for (std::size_t i = 0; i < image.radiance.pixels.size(); ++i) {
        differ += image.radiance.pixels[i] != once[1].radiance.pixels[i];
      }
      threads.add(std::to_string(count), differ);
    }
    // Two other processes have tasks of their own, render two passes each, in any order, and merge.
    Film run(24, 16), early(24, 16), late(24, 16);
    for (std::uint32_t pass = 0; pass < 4; ++pass) add_pass(run, pass, once[pass]);
    for (const std::uint32_t pass : {3u, 2u})
      add_pass(late, pass, pass_of(task_of(room, method), pass, Execution{}));
    for (const std::uint32_t pass : {0u, 1u}) {
      add_pass(early, pass, pass_of(task_of(room, method), pass, workers().execution()));
    }
    ASSERT_TRUE(merge_film(late, early).ok());
    const Image whole = film_picture(run), merged = film_picture(late);
    double differ = 0;
    for (std::size_t i = 0; i < whole.pixels.size(); ++i) differ += whole.pixels[i] != merged.pixels[i];
    split.add("", differ);
  }
}

// Photons that hit with probability p: a form factor, over the share of all paths that are emitted. With N paths fixed, hits/N has the mean p. Stopped at
// the n-th hit, n/N is too large, and only (n − 1)/(N − 1) has the mean p [Haldane 1945].
TEST(HardCase, StoppingRules37) {
  HardCase c(37, "rules to stop emission, n = 5 hits");
  Scene scene = empty_scene();
  add_mesh(scene, parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), add_material(scene, emitter(Rgb(1))));
  add_mesh(scene, parallelogram({0, 0, 1}, {0, 1, 0}, {1, 0, 0}), add_material(scene, lambert(Rgb(0))));
  const auto room = prepared(std::move(scene));
  const double x = std::sqrt(2.0);
  const double p =
      2 / std::numbers::pi * (0.5 * std::log(4.0 / 3) + 2 * x * std::atan(1 / x) - 2 * std::atan(1.0)) / room->domain.share;
  // E[n/N] by the negative binomial distribution.
  constexpr int kHits = 5;
  double term = std::pow(p, kHits), wrong = 0;  // C(N − 1, n − 1) pⁿ (1 − p)^{N − n}
  for (int n = kHits; n < 1000; ++n) {
    wrong += term * kHits / n;
    term *= (1 - p) * n / (n - kHits + 1);
  }
  Quantity& fixed = c.equals("fixed N = 25: hits/N", p);
  Quantity& unbiased = c.equals("stopped at n: (n − 1)/(N − 1)", p);
  Quantity& biased = c.equals("stopped at n: n/N, too large", wrong);
  for (const std::uint64_t seed : kSeeds) {
    Sample at_fixed, corrected, naive;
    for (std::uint32_t trial = 0; trial < 6000; ++trial) {
      const MapKey key{room->digest, {1, seed}, trial};
      int hits = 0;
      int emitted = 0;
      double after_fixed = 0;
      while (hits < kHits || emitted < 25) {
        const auto path = static_cast<std::uint64_t>(emitted++);
        const bool hit = shoot(*room, key, path, path + 1).ledger.absorbed > 0;
        if (hit && ++hits == kHits) {
          corrected.add((kHits - 1.0) / (emitted - 1));
          naive.add(static_cast<double>(kHits) / emitted);
        }
        if (emitted == 25) after_fixed = hits;
      }
      at_fixed.add(after_fixed / 25);
    }
    fixed.add("seed " + std::to_string(seed), at_fixed);
    unbiased.add("seed " + std::to_string(seed), corrected);
    biased.add("seed " + std::to_string(seed), naive);
    EXPECT_FALSE(agrees(naive, p)) << "the bias must be seen";
  }
}

// A float sum of equal terms stands still at 2²⁴ of them. A film's sums are exact, a gather's are in double.
TEST(HardCaseStatistical, BillionTerms39) {
  HardCase c(39, "sums of many terms");
  constexpr int kTerms = 1'000'000'000, kValues = 1000;
  std::array<float, kValues> values{};
  double once = 0;  // exact: multiples of 2⁻²⁴ below 2¹⁰
  Rng random(9, RngPurpose::pilot, 0, 0);
  for (float& value : values) once += value = random.next();
  ExactSum sum;
  for (int i = 0; i < kTerms / kValues; ++i) {
    for (const float value : values) sum.add(value);
  }
  c.equals("a film's sum of 10⁹ terms over the exact one", 1)
      .add("", sum.value() / (once * (kTerms / kValues)));

  std::vector<Photon> photons;
  constexpr std::uint32_t kPhotons = 20'000'000;
  photons.reserve(kPhotons);
  double expected = 0;
  Rng rng(39, RngPurpose::pilot, 39, 0);
  for (std::uint32_t i = 0; i < kPhotons; ++i) {
    const Vec2 u = rng.next2();
    photons.push_back({{u.x, u.y, 0}, encode_direction({0, 0, 1}), encode_normal({0, 0, 1}), nearest_flux(Rgb(0.125f))});
    const Vec3 d = photons.back().position - Vec3(0.5f, 0.5f, 0);
    expected += 0.125 * static_cast<double>(test::epanechnikov(glm::dot(d, d), 1)) / std::numbers::pi;
  }
  const PhotonMap map(photons, workers().execution());
  Scene scene = empty_scene();
  add_mesh(scene, parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), add_material(scene, lambert(Rgb(1))));
  const auto room = prepared(std::move(scene));
  const Ray ray{{0.5f, 0.5f, 1}, {0, 0, -1}};
  const SurfacePoint s = make_surface(room->scene, ray, room->accel.intersect(ray));
  const Bsdf bsdf(room->scene, s, {0, 0, 1});
  c.equals("one gather of 2·10⁷ photons over its sum in double", 1, {.relative = 1e-6})
      .add("", static_cast<double>(test::estimate_radiance(map, s, bsdf, kDiffuseLobe, 1).x) / expected);
}

// emitted = absorbed + escaped + truncated + rejected.
TEST(HardCase, EnergyLedger43) {
  HardCase c(43, "energy ledger");
  Quantity& gap = c.at_most("gap over what was emitted", 1e-6);
  Quantity& rejected = c.equals("rejected", 0);
  const auto room = busy_room();
  for (const std::uint64_t seed : kSeeds) {
    const EnergyLedger e = shoot_maps(*room, 50'000, seed)->ledger;
    gap.add("seed " + std::to_string(seed),
            std::abs((e.absorbed + e.escaped + e.truncated + e.rejected) / e.emitted - 1));
    rejected.add("seed " + std::to_string(seed), e.rejected);
    EXPECT_GT(e.absorbed, 0);
    EXPECT_GT(e.escaped, 0);
  }
  // What the camera's paths are cut short of is counted too.
  Quantity& cut = c.equals("camera paths cut at 3 bounces in a mirror box, of 384", 384);
  Quantity& uncut = c.equals("camera paths cut at the default depth in the busy room", 0);
  Scene mirrors = empty_scene();
  add_mesh(mirrors, box({-6, -6, -6}, {6, 6, 6}, true), add_material(mirrors, mirror(Rgb(0.9f))));
  add_point_light(mirrors, {0.1f, 0.2f, 0.3f}, Rgb(1));
  const auto hall = prepared(std::move(mirrors));
  for (const Method method : kMethods) {
    RenderTask task = task_of(hall, method);
    task.settings.max_depth = 3;
    cut.add(method_name(method), static_cast<double>(pass_of(task, 0, Execution{}).truncated));
    uncut.add(method_name(method),
              static_cast<double>(pass_of(task_of(room, method), 0, Execution{}).truncated));
  }
}

}  // namespace
}  // namespace photond
