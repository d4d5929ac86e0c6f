#include "core/trace/bsdf8.h"

#include <gtest/gtest.h>

#include "tests/support/scenes.h"

namespace photond {
namespace {

struct Case {
  const char* name;
  float metallic, roughness, specular, transmission, clearcoat = 0, clearcoat_roughness = 0;
  float sheen = 0, sheen_roughness = 0, anisotropy = 0;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

Material material(const Case& c) {
  Material m;
  m.base_color = {0.9f, 0.6f, 0.3f};
  m.metallic = c.metallic;
  m.roughness = c.roughness;
  m.specular = c.specular;
  m.specular_color = {0.9f, 0.7f, 1.0f};
  m.transmission = c.transmission;
  m.clearcoat = c.clearcoat;
  m.clearcoat_roughness = c.clearcoat_roughness;
  m.anisotropy = c.anisotropy;
  m.sheen_color = c.sheen * Rgb(1, 0.5f, 0.2f);
  m.sheen_roughness = c.sheen_roughness;
  return m;
}

Vec3 random_direction(Rng& rng) {
  for (;;) {
    const Vec3 w = 2.0f * Vec3(rng.next(), rng.next(), rng.next()) - Vec3(1);
    if (glm::dot(w, w) <= 1 && glm::dot(w, w) > 0) return glm::normalize(w);
  }
}

class EightDirections : public testing::TestWithParam<Case> {};

// On shading normals of every slant, for the lobes together and one by one.
TEST_P(EightDirections, AreEvaluatedAsOneAfterTheOther) {
  Scene scene = test::empty_scene();
  Mesh mesh = test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.uv[0] = {{0, 1}, {1, 1}, {1, 0.3f}, {0, 0.3f}};
  test::add_mesh(scene, std::move(mesh), test::add_material(scene, material(GetParam())));
  SurfacePoint surface{};
  surface.mesh = &scene.meshes[0];
  surface.material = &scene.materials[0];
  surface.vertices = scene.meshes[0].triangles[0];
  surface.front = true;
  Rng rng(3, RngPurpose::pilot, 0, 0);
  int lit = 0;
  for (int round = 0; round < 2000; ++round) {
    surface.ng = {0, 0, 1};
    Vec3 wo = random_direction(rng);
    wo.z = std::abs(wo.z);
    surface.ns = shading_normal(glm::normalize(surface.ng + 0.5f * random_direction(rng)), surface.ng, wo);
    const Bsdf bsdf(scene, surface, wo);
    Vec3x8 eight{};
    Vec3 wi[8];
    for (int k = 0; k < 8; ++k) {
      wi[k] = random_direction(rng);
      eight.x[k] = wi[k].x, eight.y[k] = wi[k].y, eight.z[k] = wi[k].z;
    }
    for (const LobeMask mask : {kDiffuseLobe, kReflectionLobe, kClearcoatLobe, kSheenLobe,
                                LobeMask{kDiffuseLobe | kReflectionLobe},
                                LobeMask{kDiffuseLobe | kReflectionLobe | kClearcoatLobe | kSheenLobe}}) {
      const Vec3x8 found = Bsdf8(bsdf, mask).eval(eight);
      for (int k = 0; k < 8; ++k) {
        const Rgb expected = bsdf.eval(wi[k], mask, Transport::radiance);
        const Rgb f(found.x[k], found.y[k], found.z[k]);
        lit += expected.x > 0;
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(f[c], expected[c], 1e-4f * expected[c] + 1e-6f) << round << " " << int{mask};
      }
    }
  }
  EXPECT_GT(lit, GetParam().roughness > 0 || GetParam().metallic < 1 ? 5000 : -1);
}

INSTANTIATE_TEST_SUITE_P(Materials, EightDirections,
                         testing::Values(Case{"lambert", 0, 1, 0, 0}, Case{"plastic", 0, 0.5f, 1, 0},
                                         Case{"rough plastic", 0, 1, 1, 0}, Case{"varnish", 0, 0, 1, 0},
                                         Case{"metal", 1, 0.6f, 1, 0}, Case{"mirror", 1, 0, 1, 0},
                                         Case{"mixed", 0.3f, 0.7f, 0.8f, 0.4f},
                                         Case{"coated lambert", 0, 1, 0, 0, 1, 0},
                                         Case{"coated plastic", 0, 0.5f, 1, 0, 0.8f, 0.6f},
                                         Case{"coated metal", 1, 0.8f, 1, 0, 1, 0.6f},
                                         Case{"coated mixed", 0.3f, 0.7f, 0.8f, 0.4f, 0.6f, 0.5f},
                                         Case{"velvet", 0, 1, 0, 0, 0, 0, 0.9f, 0},
                                         Case{"felt", 0, 0.8f, 1, 0, 0, 0, 1, 0.7f},
                                         Case{"sheen on metal", 1, 0.6f, 1, 0, 0, 0, 0.5f, 0.2f},
                                         Case{"coated sheen on mixed", 0.3f, 0.7f, 0.8f, 0.4f, 0.6f, 0.5f, 1, 0.4f},
                                         Case{"brushed metal", 1, 0.6f, 1, 0, 0, 0, 0, 0, 0.8f},
                                         Case{"brushed mixed", 0.3f, 0.7f, 0.8f, 0.4f, 0.6f, 0.5f, 1, 0.4f, 0.6f}));

}  // namespace
}  // namespace photond
