#include "core/trace/emission_domain.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "core/math/frame.h"
#include "core/math/warp.h"
#include "core/trace/prepare.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

using test::Sample;

TEST(EmissionDomain, StartsAreUniform) {
  const EmissionDomain::Cells cells{2, 1, 2};
  const std::vector<std::uint16_t> members = {0, 5, 17, 63, 64, 100, 127};
  const EmissionDomain domain(cells, members);
  EXPECT_FLOAT_EQ(domain.share(), 7.0f / 128);
  // Cells of half their size, so that places within them count, too.
  constexpr std::uint32_t kFine = 16;
  std::vector<double> observed(128 * kFine), expected(128 * kFine);
  Rng rng(1, RngPurpose::pilot, 0, 0);
  constexpr int kDraws = 100'000;
  for (int i = 0; i < kDraws; ++i) {
    const EmissionStart s = domain.draw(rng);
    ASSERT_TRUE(domain.contains(s));
    const auto x = glm::uvec2(s.place * 4.0f), d = glm::uvec2(s.direction * 8.0f);
    const std::uint32_t place = x.y / 2 * 2 + x.x / 2, direction = d.y / 2 * 4 + d.x / 2;
    const std::uint32_t cell = (s.back * 4 + place) * 16 + direction;
    const std::uint32_t fine = ((x.y % 2 * 2 + x.x % 2) * 2 + d.y % 2) * 2 + d.x % 2;
    ++observed[cell * kFine + fine];
  }
  for (const std::uint32_t cell : members) {
    for (std::uint32_t f = 0; f < kFine; ++f) expected[cell * kFine + f] = kDraws / (7.0 * kFine);
  }
  EXPECT_GT(test::chi2_test(observed, expected), test::kSignificance);
}

TEST(EmissionDomain, TheWholeIsUniformOverBothSides) {
  const EmissionDomain domain(2);
  EXPECT_EQ(domain.share(), 1);
  Rng rng(2, RngPurpose::pilot, 0, 0);
  Sample back, mean;
  for (int i = 0; i < 10'000; ++i) {
    const EmissionStart s = domain.draw(rng);
    EXPECT_TRUE(domain.contains(s));
    back.add(s.back);
    mean.add(static_cast<double>(s.place.x + s.place.y + s.direction.x + s.direction.y));
  }
  EXPECT_NEAR(back.mean, 0.5, test::kSigmas * back.standard_error());
  EXPECT_NEAR(mean.mean, 2, test::kSigmas * mean.standard_error());
}

// A lamp above things that fill a small part of what it sees.
struct Place {
  std::string name;
  Scene scene;
};

void add_things(Scene& scene) {
  const std::uint32_t grey = test::add_material(scene, test::lambert(Rgb(0.5f)));
  test::add_mesh(scene, test::parallelogram({-1, 0, -1}, {0, 0, 2}, {2, 0, 0}), grey);
  test::add_mesh(scene, test::sphere({1.5f, 0.8f, 0.5f}, 0.3f, 8), grey);
  const std::uint32_t ball = test::add_mesh(scene, test::sphere({0, 0, 0}, 0.1f, 6), grey);
  for (int i = 0; i < 6; ++i) {
    scene.instances.push_back(scene.instances.back());
    scene.instances.back().mesh = ball;
    scene.instances.back().to_world[3] = Vec3(0.7f * i, 1 + 0.1f * i, -0.5f * i);
  }
}

void add_lamp(Scene& scene, Mesh mesh, bool double_sided = false) {
  Material shining = test::emitter({3, 2, 1});
  shining.double_sided = double_sided;
  test::add_mesh(scene, std::move(mesh), test::add_material(scene, shining));
}

std::vector<Place> places() {
  std::vector<Place> places;
  const auto place = [&](const char* name) -> Scene& {
    Place& p = places.emplace_back(name, test::empty_scene());
    add_things(p.scene);
    return p.scene;
  };
  add_lamp(place("level"), test::parallelogram({-0.3f, 5, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}));
  add_lamp(place("tilted"), test::parallelogram({4, 3, 1}, {0.1f, 0.3f, 0.2f}, {-0.2f, 0.4f, -0.1f}), true);
  add_lamp(place("wide"), test::parallelogram({-3, 6, -3}, {6, 0, 0}, {0, 0, 6}));
  add_lamp(place("a bulb"), test::faceted(test::sphere({0, 4, 0}, 0.2f, 6)));
  add_lamp(place("many triangles"), test::faceted(test::sphere({1, 3, 0}, 0.1f, 12)));
  Scene& housed = place("in a housing");
  add_lamp(housed, test::parallelogram({-0.3f, 5, -0.3f}, {0.6f, 0, 0.1f}, {0, 0.2f, 0.6f}));
  test::add_mesh(housed, test::parallelogram({-0.3f, 5, -0.3f}, {-0.6f, 0, -0.1f}, {0, 0.2f, 0.6f}), 0);
  return places;
}

// The path that leaves an emissive triangle from there.
Ray path(const EmitterTriangle& emitter, const EmissionStart& start) {
  const Vec3 normal = start.back ? -emitter.normal : emitter.normal;
  const Vec3 direction = Frame(normal).to_world(square_to_cosine_hemisphere(start.direction));
  return {spawn_point(emitter.at(square_to_triangle(start.place)), emitter.normal, emitter.extent, direction), direction};
}

TEST(FindDomain, MissesNothingThatPathsMeet) {
  for (auto& [name, scene] : places()) {
    const auto prepared = test::prepared(std::move(scene));
    const auto boxes = surface_boxes(prepared->scene, prepared->bounds);
    const auto emitters = prepared->lights.emitters();
    Rng rng(3, RngPurpose::pilot, 0, 0);
    int meeting = 0, inside = 0, paths = 0, missed = 0;
    for (std::size_t e = 0; e < emitters.size(); e += std::max<std::size_t>(emitters.size() / 8, 1)) {
      const bool both = prepared->scene.materials[emitters[e].material].double_sided;
      const EmissionDomain domain = find_domain(emitters[e], both, true, emitters.size(), boxes), whole(both ? 2 : 1);
      for (int i = 0; i < 20'000; ++i, ++paths) {
        const EmissionStart start = whole.draw(rng);
        const bool found = prepared->accel.intersect(path(emitters[e], start)).found(), in = domain.contains(start);
        meeting += found;
        inside += in;
        missed += found && !in;
      }
    }
    EXPECT_EQ(missed, 0) << name;
    EXPECT_GT(meeting, 0) << name;
    EXPECT_LT(inside - meeting, 0.3 * paths) << name;
  }
}

// Paths that leave the domain carry the same to everywhere as those that leave in any direction, and the more of them
// meet something, the less they differ.
TEST(EmissionDomains, BringTheSameFluxEverywhere) {
  for (auto& [name, scene] : places()) {
    const auto prepared = test::prepared(std::move(scene));
    ASSERT_TRUE(prepared->domain.active) << name;
    const Lights ordinary(prepared->scene, prepared->bounds);
    const auto fluxes = [&](const Lights& lights, std::uint64_t seed) {
      std::vector<Sample> flux(prepared->scene.instances.size());
      for (std::uint64_t i = 0; i < 60'000; ++i) {
        Rng rng(seed, RngPurpose::photon, 0, i);
        const EmissionSample s = lights.sample_emission(prepared->scene, rng);
        const Hit hit = prepared->accel.intersect(s.ray);
        for (std::size_t k = 0; k < flux.size(); ++k) flux[k].add(hit.instance == k ? static_cast<double>(s.flux.x) : 0);
      }
      return flux;
    };
    const auto with = fluxes(prepared->lights, 1), without = fluxes(ordinary, 2);
    for (std::size_t k = 0; k < with.size(); ++k) {
      EXPECT_NEAR(with[k].mean, without[k].mean,
                  test::kSigmas * std::hypot(with[k].standard_error(), without[k].standard_error()))
          << name << ", instance " << k;
    }
    EXPECT_LT(with[1].standard_error(), without[1].standard_error()) << name;
  }
}

TEST(EmissionDomains, TellTheEtendueThatPathsHave) {
  for (auto& [name, scene] : places()) {
    const auto prepared = test::prepared(std::move(scene));
    Rng rng(4, RngPurpose::pilot, 0, 0);
    int differ = 0, seen = 0;
    for (int i = 0; i < 1000; ++i) {
      const EmissionSample s = prepared->lights.sample_emission(prepared->scene, rng);
      const Ray back{s.ray.origin + 1e-3f * s.ray.direction, -s.ray.direction};
      const Hit hit = prepared->accel.intersect(back);
      if (!hit.found()) continue;   // by an edge
      ++seen;
      differ += prepared->lights.etendue(prepared->scene, make_surface(prepared->scene, back, hit), s.ray.direction) != s.etendue;
      EXPECT_FLOAT_EQ(s.flux.x, 3 * s.etendue) << name;
    }
    EXPECT_GT(seen, 900) << name;
    EXPECT_LE(differ, 20) << name;   // by the rim of a triangle the next one is met
  }
}

TEST(EmissionDomains, LanesEmitWhatSingleSamplesDo) {
  for (auto& [name, scene] : places()) {
    const auto prepared = test::prepared(std::move(scene));
    const Lights& lights = prepared->lights;
    const auto lanes = std::make_unique<EmissionLanes>();
    Rng rng(5, RngPurpose::pilot, 0, 0);
    for (int i = 0; i < 1000; ++i) {
      const std::uint32_t light = lights.choose(rng.next());
      Rng same = rng;
      const EmissionSample single = lights.sample_emission(prepared->scene, light, same);
      ASSERT_TRUE(lights.begin_emission(prepared->scene, light, rng, 0, *lanes)) << name;
      lanes->emit(1);
      EXPECT_LT(glm::distance(lanes->direction[0], single.ray.direction), 1e-5f) << name;
      EXPECT_LT(glm::distance(lanes->position[0], single.ray.origin), 1e-5f) << name;
      EXPECT_EQ(lanes->flux[0], single.flux) << name;
      EXPECT_EQ(rng.next_uint(), same.next_uint()) << name;
    }
  }
}

TEST(EmissionDomains, AreFoundWhereMuchLightMeetsNothing) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::box({-1, 0, -1}, {1, 2, 1}, true), test::add_material(scene, test::lambert(Rgb(0.5f))));
  add_lamp(scene, test::parallelogram({-0.3f, 1.9f, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}));
  const auto closed = test::prepared(scene);
  EXPECT_FALSE(closed->domain.active);
  EXPECT_EQ(closed->domain.meeting, 1);
  EXPECT_EQ(closed->lights.unsent(0), 0);
  const auto dark = test::prepared(test::empty_scene());
  EXPECT_FALSE(dark->domain.active);
  EXPECT_FALSE(dark->domain.emitters);
}

// A lamp that shines on nothing leaves its paths to one that does.
TEST(EmissionDomains, PathsLeaveLampsThatShineOnSomething) {
  Scene scene = test::empty_scene();
  add_things(scene);
  add_lamp(scene, test::parallelogram({-0.3f, 5, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}));
  add_lamp(scene, test::parallelogram({-0.3f, 7, -0.3f}, {0, 0, 0.6f}, {0.6f, 0, 0}));
  const auto prepared = test::prepared(std::move(scene));
  ASSERT_EQ(prepared->lights.size(), 4u);
  EXPECT_GT(prepared->lights.probability(0) + prepared->lights.probability(1), 0.999f);
  EXPECT_LT(prepared->lights.probability(2), 1e-3f);
}

TEST(EmissionDomains, DoNotDependOnThreads) {
  for (auto& [name, scene] : places()) {
    const auto one = test::prepared(scene);
    const auto many = *prepare(std::move(scene), test::workers().execution());
    for (std::uint32_t light = 0; light < one->lights.size(); ++light) {
      EXPECT_EQ(one->lights.unsent(light), many->lights.unsent(light)) << name;
    }
  }
}

}  // namespace
}  // namespace photond
