#include "core/trace/scatter_flux.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <tuple>

#include "core/math/warp.h"
#include "core/trace/gathered.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

constexpr float kMost = 1e6f;   // no bound

Material plastic(float roughness) {
  Material m = test::lambert(Rgb(0.7f));
  m.specular = 1;
  m.roughness = roughness;
  return m;
}

Material metal(float roughness) {
  Material m = test::mirror(Rgb(0.9f));
  m.roughness = roughness;
  return m;
}

Material rough_glass() {
  Material m = test::glass(1.5f);
  m.roughness = 0.6f;
  return m;
}

Material coated(Material m, float roughness) {
  m.clearcoat = 1;
  m.clearcoat_roughness = roughness;
  return m;
}

Material brushed(Material m) {
  m.anisotropy = 0.7f;
  m.anisotropy_rotation = 0.6f;
  return m;
}

Material sheened(Material m, float roughness) {
  m.sheen_color = Rgb(0.9f, 0.5f, 0.2f);
  m.sheen_roughness = roughness;
  return m;
}

// Bumps below a smooth coat, all alike.
Material bumpy(Material m) {
  m.normal_texture.texture = 0;
  return m;
}

// The plane z = 0, all of whose shading normals are tilted by as many degrees towards x.
struct Tilted {
  Scene scene = test::empty_scene();

  Tilted(const Material& material, float degrees) {
    Mesh mesh = test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const float angle = degrees * kPi / 180;
    mesh.normals.assign(mesh.positions.size(), {std::sin(angle), 0, std::cos(angle)});
    mesh.uv[0].clear();
    for (const Vec3& p : mesh.positions) mesh.uv[0].emplace_back(p.x, 1 - p.y);
    scene.images.push_back({.width = 1, .height = 1, .u8 = {160, 90, 235, 255}});
    scene.textures.push_back({});
    test::add_mesh(scene, std::move(mesh), test::add_material(scene, material));
    scene = test::prepared(std::move(scene))->scene;
  }
  SurfacePoint seen_from(const Vec3& wo) const {
    Hit hit;
    hit.t = 1;
    hit.u = hit.v = 0.25f;
    hit.instance = hit.triangle = 0;
    return make_surface(scene, {Vec3(0.25f, 0.25f, 0) + wo, -wo}, hit);
  }
};

enum class Part { gathered, others };

// Flux towards directions beyond and within the horizon of the shading normal, weighted so that all places tell apart.
double value(const Vec3& out) { return 1 + static_cast<double>(0.5f * out.y + 0.3f * out.x * out.x); }
bool beyond(const Vec3& out) { return out.x < -0.7f * std::abs(out.z); }

// What paths from the eye that arrive from everywhere are shown of light from `wi`, per flux of that.
test::Sample shown(const Tilted& plane, const Vec3& wi, Part part, bool far) {
  return test::draw(1'000'000, [&](Rng& rng) {
    const Vec3 out = square_to_sphere(rng.next2());
    if (beyond(out) != far) return 0.0;
    const SurfacePoint s = plane.seen_from(out);
    const Bsdf bsdf(plane.scene, s, out);
    const LobeMask gathered = gathered_lobes(bsdf);
    const Rgb f = bsdf.eval(wi, part == Part::gathered ? gathered : kAllLobes & ~gathered, Transport::radiance);
    const float factor = std::abs(glm::dot(wi, s.ns) * out.z / wi.z);
    return static_cast<double>(f.x * factor / kSpherePdf) * value(out);
  });
}

test::Sample carried(const Tilted& plane, const Vec3& wi, Part part, bool far) {
  const SurfacePoint s = plane.seen_from(wi);
  const Bsdf bsdf(plane.scene, s, wi);
  return test::draw(1'000'000, [&](Rng& rng) {
    FluxSample sample;
    if (!scatter_flux(plane.scene, s, bsdf, wi, kMost, rng, sample)) return 0.0;
    const bool wanted = sample.by_gathered == (part == Part::gathered) && beyond(sample.wi) == far;
    return wanted ? static_cast<double>(sample.weight.x) * value(sample.wi) : 0.0;
  });
}

struct Case {
  const char* name;
  Material material;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class ScatterFlux : public testing::TestWithParam<std::tuple<Case, float, float>> {};

TEST_P(ScatterFlux, IsTheAdjointOfWhatPathsSee) {
  const auto& [c, tilt, height] = GetParam();
  const Tilted plane(c.material, tilt);
  const Vec3 wi = glm::normalize(Vec3(0.6f, 0.3f, 0) * std::sqrt(1 - height * height) / std::hypot(0.6f, 0.3f) +
                                 Vec3(0, 0, height));
  for (const Part part : {Part::gathered, Part::others}) {
    for (const bool far : {false, true}) {
      const test::Sample expected = shown(plane, wi, part, far), seen = carried(plane, wi, part, far);
      const double error = std::hypot(expected.standard_error(), seen.standard_error());
      constexpr double kRounding = 1e-5;   // where directions are so rare that none may be drawn
      EXPECT_NEAR(seen.mean, expected.mean, test::kSigmas * error + kRounding)
          << c.name << (part == Part::gathered ? ", gathered" : ", others") << (far ? ", beyond" : "");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Materials, ScatterFlux,
    testing::Combine(testing::Values(Case{"lambert", test::lambert(Rgb(0.7f))}, Case{"plastic", plastic(0.6f)},
                                     Case{"glossy plastic", plastic(0.4f)}, Case{"metal", metal(0.7f)},
                                     Case{"rough glass", rough_glass()},
                                     Case{"coated lambert", coated(test::lambert(Rgb(0.7f)), 0.7f)},
                                     Case{"coated glossy plastic", coated(plastic(0.4f), 0.3f)},
                                     Case{"coated bumps", bumpy(coated(test::lambert(Rgb(0.7f)), 0.7f))},
                                     Case{"brushed metal", brushed(metal(0.7f))},
                                     Case{"brushed plastic", brushed(plastic(0.4f))},
                                     Case{"velvet", sheened(test::lambert(Rgb(0.7f)), 0.3f)},
                                     Case{"coated felt", coated(sheened(plastic(0.6f), 0.8f), 0.3f)}),
                     testing::Values(0.0f, 10.0f, 45.0f), testing::Values(0.2f, 0.8f)));

// A smooth coat reflects as a mirror, about its tilted normal; the base below it as above.
TEST(ScatterFlux, CoatsReflectBesideTheirBase) {
  const Tilted plane(plastic(0), 20);
  const Vec3 wi = glm::normalize(Vec3(0.2f, 0.1f, 1));
  const SurfacePoint s = plane.seen_from(wi);
  const Bsdf bsdf(plane.scene, s, wi);
  const Vec3 mirrored = 2 * glm::dot(wi, s.ns) * s.ns - wi;
  test::Sample base, coat;
  Rng rng(3, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < 200'000; ++i) {
    FluxSample sample;
    const bool scattered = scatter_flux(plane.scene, s, bsdf, wi, kMost, rng, sample);
    const bool by_coat = scattered && glm::distance(sample.wi, mirrored) < 1e-4f;
    base.add(scattered && !by_coat ? static_cast<double>(sample.weight.x) * value(sample.wi) : 0);
    coat.add(by_coat ? static_cast<double>(sample.weight.x) : 0);
  }
  const test::Sample below = shown(plane, wi, Part::gathered, false), beyond = shown(plane, wi, Part::gathered, true);
  EXPECT_NEAR(base.mean, below.mean + beyond.mean,
              test::kSigmas * (base.standard_error() + below.standard_error() + beyond.standard_error()));
  const double fresnel = 0.04 + 0.96 * std::pow(1 - static_cast<double>(glm::dot(wi, s.ns)), 5);
  const double factor = static_cast<double>(glm::dot(wi, s.ns) * mirrored.z / (wi.z * glm::dot(mirrored, s.ns)));
  EXPECT_NEAR(coat.mean, fresnel * factor, test::kSigmas * coat.standard_error());
}

// What mirrors and smooth glass show to paths that arrive from everywhere, of light that arrives from everywhere: both
// weighted so that all places tell apart.
double light(const Vec3& from) {
  return 1 + static_cast<double>(0.7f * from.x + 0.4f * from.y + 0.2f * from.z * from.x);
}

class SmoothFlux : public testing::TestWithParam<std::tuple<Case, float>> {};

TEST_P(SmoothFlux, IsTheAdjointOfWhatPathsSee) {
  const auto& [c, tilt] = GetParam();
  const Tilted plane(c.material, tilt);
  constexpr std::uint64_t kDraws = 400'000;
  const auto seen = [&](bool far) {
    return test::draw(kDraws, [&](Rng& rng) {
      const Vec3 out = square_to_sphere(rng.next2());
      const Vec2 u = rng.next2();
      if (beyond(out) != far) return 0.0;
      const Bsdf bsdf(plane.scene, plane.seen_from(out), out);
      const auto sample = bsdf.sample({u, rng.next()}, kAllLobes, Transport::radiance);
      if (!sample || !sample->delta) return 0.0;
      return static_cast<double>(sample->weight.x * std::abs(out.z) / kSpherePdf) * light(sample->wi) * value(out);
    });
  };
  const auto carried = [&](bool far) {
    return test::draw(kDraws, [&](Rng& rng) {
      const Vec3 from = square_to_sphere(rng.next2());
      const SurfacePoint s = plane.seen_from(from);
      const Bsdf bsdf(plane.scene, s, from);
      FluxSample sample;
      if (!scatter_flux(plane.scene, s, bsdf, from, kMost, rng, sample)) return 0.0;
      if (sample.by_gathered || beyond(sample.wi) != far) return 0.0;
      return static_cast<double>(sample.weight.x * std::abs(from.z) / kSpherePdf) * light(from) * value(sample.wi);
    });
  };
  for (const bool far : {false, true}) {
    const test::Sample expected = seen(far), photons = carried(far);
    const double error = std::hypot(expected.standard_error(), photons.standard_error());
    constexpr double kRounding = 1e-5;   // where directions are so rare that none may be drawn
    EXPECT_NEAR(photons.mean, expected.mean, test::kSigmas * error + kRounding) << c.name << (far ? ", beyond" : "");
  }
}

Material coated_bumps() { return bumpy(coated(test::lambert(Rgb(0.7f)), 0)); }

Material thin_glass() {
  Material m = test::glass(1.5f);
  m.thin_walled = true;
  return m;
}

INSTANTIATE_TEST_SUITE_P(Materials, SmoothFlux,
                         testing::Combine(testing::Values(Case{"mirror", metal(0)}, Case{"glass", test::glass(1.5f)},
                                                          Case{"dense glass", test::glass(2.4f)},
                                                          Case{"thin glass", thin_glass()}, Case{"plastic", plastic(0)},
                                                          Case{"coated bumps", coated_bumps()}),
                                          testing::Values(0.0f, 10.0f, 30.0f, 50.0f)));

}  // namespace
}  // namespace photond
