// Samplers against their densities, energy and reciprocity of the BSDFs.
#include "core/trace/bsdf.h"

#include <gtest/gtest.h>

#include "core/trace/gathered.h"
#include "core/trace/microfacet.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

using test::agrees;
using test::chi2_sphere;
using test::draw;
using test::Sample;

struct Case {
  const char* name;
  Material material;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

Material metal(float roughness) {
  Material m;
  m.base_color = {1.0f, 0.8f, 0.4f};
  m.metallic = 1;
  m.roughness = roughness;
  return m;
}

Material plastic(float roughness, const Rgb& base = Rgb(0.5f)) {
  Material m;
  m.base_color = base;
  m.metallic = 0;
  m.roughness = roughness;
  return m;
}

Material rough_glass(float roughness, bool thin) {
  Material m = test::glass(1.5f);
  m.roughness = roughness;
  m.thin_walled = thin;
  return m;
}

Material mixed() {
  Material m;
  m.base_color = {0.9f, 0.6f, 0.3f};
  m.metallic = 0.3f;
  m.roughness = 0.6f;
  m.transmission = 0.4f;
  m.thin_walled = false;
  m.specular = 0.8f;
  m.specular_color = {0.9f, 0.7f, 1.0f};
  return m;
}

Material coated(Material m, float roughness, float amount = 1) {
  m.clearcoat = amount;
  m.clearcoat_roughness = roughness;
  return m;
}

// Highlights are longest at an angle to everything else.
Material brushed(Material m, float strength) {
  m.anisotropy = strength;
  m.anisotropy_rotation = 0.4f;
  return m;
}

// Along the tangent, where turning the surface over changes nothing.
Material along(Material m) {
  m.anisotropy_rotation = 0;
  return m;
}

Material sheened(Material m, float roughness, const Rgb& color = Rgb(0.8f, 0.3f, 0.6f)) {
  m.sheen_color = color;
  m.sheen_roughness = roughness;
  return m;
}

// A surface in the plane z = 0 seen from `wo`.
struct Plane {
  Scene scene;
  SurfacePoint surface;

  explicit Plane(const Material& material, bool front = true) {
    scene = test::empty_scene();
    Mesh mesh = test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    mesh.uv[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    test::add_mesh(scene, std::move(mesh), test::add_material(scene, material));
    surface.ng = surface.ns = {0, 0, 1};
    surface.u = surface.v = 0;
    surface.instance = surface.triangle = 0;
    surface.front = front;
    surface.mesh = &scene.meshes[0];
    surface.material = &scene.materials[0];
    surface.ior = material.ior;
    surface.vertices = scene.meshes[0].triangles[0];
  }
  Bsdf bsdf(const Vec3& wo) const { return {scene, surface, wo}; }
};

Vec3 direction(float degrees, float azimuth = 0.7f) {
  const float theta = degrees * kPi / 180;
  return {std::sin(theta) * std::cos(azimuth), std::sin(theta) * std::sin(azimuth), std::cos(theta)};
}

class BsdfSampling : public testing::TestWithParam<std::tuple<Case, float, bool>> {};

TEST_P(BsdfSampling, HistogramMatchesPdf) {
  const auto& [c, degrees, front] = GetParam();
  const Plane setup(c.material, front);
  const Bsdf bsdf = setup.bsdf(direction(degrees));
  const double p = chi2_sphere(
      [&](Rng& rng) {
        const Vec2 u = rng.next2();
        const auto s = bsdf.sample({u, rng.next()}, kAllLobes, Transport::radiance);
        return s ? s->wi : Vec3(0);
      },
      [&](const Vec3& wi) {
        // Directions that the horizon rejects have a density but are never returned.
        return static_cast<double>(bsdf.pdf(wi, kAllLobes));
      });
  EXPECT_GT(p, test::kSignificance);
}

TEST_P(BsdfSampling, WeightIsValueOverPdf) {
  const auto& [c, degrees, front] = GetParam();
  const Plane setup(c.material, front);
  const Bsdf bsdf = setup.bsdf(direction(degrees));
  Rng rng(5, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < 2000; ++i) {
    const Vec2 u = rng.next2();
    const auto s = bsdf.sample({u, rng.next()}, kAllLobes, Transport::flux);
    if (!s) continue;
    EXPECT_NEAR(s->pdf_w, bsdf.pdf(s->wi, kAllLobes), 1e-3f * s->pdf_w);
    const Rgb value = bsdf.eval(s->wi, kAllLobes, Transport::flux) * std::abs(s->wi.z);
    // Relative: float cancellation near grazing half vectors.
    EXPECT_NEAR(s->weight.y * s->pdf_w, value.y, 2e-3f * value.y + 1e-6f);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Materials, BsdfSampling,
    testing::Combine(testing::Values(Case{"lambert", test::lambert(Rgb(0.7f))}, Case{"plastic .5", plastic(0.5f)},
                                     Case{"plastic 1", plastic(1)}, Case{"metal .4", metal(0.4f)},
                                     Case{"metal 1", metal(1)}, Case{"rough glass", rough_glass(0.6f, false)},
                                     Case{"thin rough glass", rough_glass(0.6f, true)}, Case{"mixed", mixed()},
                                     Case{"coated lambert", coated(test::lambert(Rgb(0.7f)), 0.5f)},
                                     Case{"coated metal", coated(metal(0.4f), 0.7f)},
                                     Case{"coated mixed", coated(mixed(), 0.5f, 0.6f)},
                                     Case{"velvet", sheened(test::lambert(Rgb(0.7f)), 0.2f)},
                                     Case{"felt", sheened(plastic(0.8f), 0.8f)},
                                     Case{"sheen on metal", sheened(metal(0.4f), 0.4f)},
                                     Case{"coated sheen on mixed", coated(sheened(mixed(), 0.5f), 0.5f, 0.6f)},
                                     Case{"brushed metal", brushed(metal(0.4f), 0.8f)},
                                     // Not so rough that much of it is seen at the edge of all refraction, within a cell.
                                     Case{"brushed glass", brushed(rough_glass(0.3f, false), 0.4f)},
                                     Case{"brushed mixed", brushed(coated(mixed(), 0.5f, 0.6f), 0.6f)}),
                     testing::Values(5.0f, 45.0f, 75.0f), testing::Bool()));

// ∫ f cos over the sphere, by the sampler.
Sample albedo(const Bsdf& bsdf, Transport transport, std::uint64_t count = 100'000) {
  return draw(count, [&](Rng& rng) {
    const Vec2 u = rng.next2();
    const auto s = bsdf.sample({u, rng.next()}, kAllLobes, transport);
    return s ? static_cast<double>(s->weight.x) : 0.0;
  });
}

TEST(BsdfEnergy, LambertReflectsItsAlbedoExactly) {
  const Plane setup(test::lambert(Rgb(0.3f)));
  EXPECT_TRUE(agrees(albedo(setup.bsdf(direction(60)), Transport::radiance), 0.3));
}

TEST(BsdfEnergy, SmoothMirrorReflectsItsColour) {
  const Plane setup(test::mirror(Rgb(0.9f)));
  for (const float degrees : {0.0f, 45.0f, 89.0f}) {
    EXPECT_TRUE(agrees(albedo(setup.bsdf(direction(degrees)), Transport::flux, 1000), 0.9)) << degrees;
  }
}

TEST(BsdfEnergy, SmoothGlassLosesNothing) {
  for (const bool front : {true, false}) {
    for (const float degrees : {0.0f, 30.0f, 60.0f, 85.0f}) {
      const Plane setup(test::glass(1.5f), front);
      EXPECT_TRUE(agrees(albedo(setup.bsdf(direction(degrees)), Transport::flux), 1)) << degrees << front;
    }
  }
}

// What cannot leave glass is reflected, however little of its reflection a file wants: nothing else could become of it.
TEST(BsdfEnergy, TotalReflectionIsTotal) {
  for (const float roughness : {0.0f, 0.1f}) {
    Material dull = test::glass(1.5f);
    dull.roughness = roughness;
    dull.specular = 0;
    const Plane setup(dull, false);
    EXPECT_NEAR(albedo(setup.bsdf(direction(65)), Transport::flux).mean, 1, 0.005) << roughness;
  }
}

// Radiance is compressed by the square of the index: seen from outside, T/η² + R.
TEST(BsdfEnergy, RefractionScalesRadianceByTheIndexSquared) {
  const Plane setup(test::glass(1.5f));
  const double fresnel = 0.04;
  EXPECT_TRUE(agrees(albedo(setup.bsdf({0, 0, 1}), Transport::radiance, 400'000), fresnel + (1 - fresnel) / 2.25));
}

// A white base below the layer and the layer together reflect everything: the layering conserves energy. The
// tolerance is the interpolation error of the layer's table.
TEST(BsdfEnergy, WhitePlasticPassesTheFurnace) {
  for (const float roughness : {0.0f, 0.2f, 0.5f, 1.0f}) {
    for (const float degrees : {0.0f, 45.0f, 80.0f}) {
      const Plane setup(plastic(roughness, Rgb(1)));
      const Sample a = albedo(setup.bsdf(direction(degrees)), Transport::radiance);
      EXPECT_NEAR(a.mean, 1, 0.004 + 4 * a.standard_error()) << roughness << " at " << degrees;
    }
  }
}

// And so do two layers, whatever their roughness.
TEST(BsdfEnergy, WhiteBelowAClearcoatPassesTheFurnace) {
  for (const float roughness : {0.0f, 0.3f, 1.0f}) {
    for (const float degrees : {0.0f, 45.0f, 80.0f}) {
      for (const Material& m : {test::lambert(Rgb(1)), plastic(0, Rgb(1)), plastic(0.6f, Rgb(1)), test::mirror(Rgb(1))}) {
        const Plane setup(coated(m, roughness));
        const Sample a = albedo(setup.bsdf(direction(degrees)), Transport::radiance);
        // A mirror keeps all but where the coat's lobe is lost below the horizon.
        const double lost = m.metallic == 1 ? 0.45 * static_cast<double>(roughness * roughness) : 0;
        EXPECT_LT(a.mean, 1 + 0.004 + 4 * a.standard_error()) << roughness << " at " << degrees;
        EXPECT_GT(a.mean, 1 - lost - 0.004 - 4 * a.standard_error()) << roughness << " at " << degrees;
      }
    }
  }
}

// So does what is below fibres; a base that is rough and itself depends on directions keeps somewhat less.
TEST(BsdfEnergy, WhiteBelowASheenPassesTheFurnace) {
  for (const float roughness : {0.0f, 0.15f, 0.4f, 1.0f}) {
    for (const float degrees : {0.0f, 45.0f, 80.0f, 87.0f}) {
      for (const Material& m : {test::lambert(Rgb(1)), plastic(0, Rgb(1)), plastic(0.6f, Rgb(1)), test::mirror(Rgb(1)),
                                coated(test::lambert(Rgb(1)), 0.3f), coated(plastic(0.6f, Rgb(1)), 0)}) {
        const Plane setup(sheened(m, roughness, Rgb(1)));
        const Sample a = albedo(setup.bsdf(direction(degrees)), Transport::radiance, 20'000);
        const double lost = m.clearcoat > 0 ? 0.05 : m.roughness == 0.6f ? 0.025 : 0;
        EXPECT_LT(a.mean, 1 + 0.005 + 4 * a.standard_error()) << roughness << " at " << degrees;
        EXPECT_GT(a.mean, 1 - lost - 0.005 - 4 * a.standard_error()) << roughness << " at " << degrees;
      }
    }
  }
}

// What shines in one colour takes its share of the others, too.
TEST(BsdfEnergy, SheenDimsWhatIsBelow) {
  const Plane setup(sheened(test::lambert(Rgb(0.5f)), 0.5f, {0, 0.9f, 0}));
  const Bsdf bsdf = setup.bsdf(direction(70));
  EXPECT_EQ(gathered_lobes(bsdf), kDiffuseLobe | kSheenLobe);
  const double through = static_cast<double>(Sheen({0, 0.9f, 0}, 0.5f, std::cos(70 * kPi / 180), false).through());
  EXPECT_LT(through, 0.8);
  EXPECT_NEAR(albedo(bsdf, Transport::radiance).mean, 0.5 * through, 0.002);
  EXPECT_FLOAT_EQ(bsdf.diffuse_albedo().x, 0.5f * static_cast<float>(through));
}

// Glass below fibres loses on the way out what they hold back, and nothing more on the way in.
TEST(BsdfEnergy, SheenOverGlass) {
  for (const bool thin : {true, false}) {
    const Plane outside(sheened(rough_glass(0, thin), 0.6f, Rgb(1)));
    EXPECT_NEAR(albedo(outside.bsdf(direction(70)), Transport::flux).mean, 1, 0.01) << thin;
  }
  const Plane inside(sheened(test::glass(1.5f), 0.6f, Rgb(1)), false);
  EXPECT_EQ(inside.bsdf({0, 0, 1}).lobes(), kGlassLobe);
  const double through = static_cast<double>(Sheen(Rgb(1), 0.6f, 1, false).through());
  EXPECT_NEAR(albedo(inside.bsdf({0, 0, 1}), Transport::flux).mean, 0.04 + 0.96 * through, 0.002);
}

// A white base below brushed layers, whose albedo is taken from that of isotropic ones: within 2 %.
TEST(BsdfEnergy, WhiteBelowABrushedLayerPassesTheFurnace) {
  for (const float strength : {0.3f, 0.7f, 1.0f}) {
    for (const float degrees : {0.0f, 45.0f, 80.0f}) {
      for (const float azimuth : {0.4f, 0.4f + kPi / 2}) {
        const Plane setup(brushed(plastic(0.2f, Rgb(1)), strength));
        const Sample a = albedo(setup.bsdf(direction(degrees, azimuth)), Transport::radiance);
        EXPECT_NEAR(a.mean, 1, 0.02 + 4 * a.standard_error()) << strength << " at " << degrees << ", " << azimuth;
      }
    }
  }
}

// Highlights reach far along the direction that the file says, turned by its texture, and not across it.
TEST(BsdfBrushed, HighlightsAreLongInTheirDirection) {
  Material m = brushed(metal(0.2f), 0.9f);
  const auto f = [](const Plane& plane, float azimuth) {
    return plane.bsdf({0, 0, 1}).eval(direction(40, azimuth), kReflectionLobe, Transport::radiance).x;
  };
  const Plane untextured(m);
  EXPECT_GT(f(untextured, 0.4f), 20 * f(untextured, 0.4f + kPi / 2));
  m.anisotropy_texture.texture = 0;
  Plane turned(m);
  turned.scene.images.push_back({.width = 1, .height = 1, .u8 = {0, 255, 255, 255}});   // (−1, 1)
  turned.scene.textures.push_back({});
  EXPECT_NEAR(f(turned, 0.4f + 0.75f * kPi), f(untextured, 0.4f), 2e-3f * f(untextured, 0.4f));
  turned.scene.images[0].u8 = {255, 128, 0, 255};   // of no strength
  const Plane even(metal(0.2f));
  EXPECT_FLOAT_EQ(f(turned, 0.4f), f(even, 0.4f));
}

// Without tangents and texture coordinates nothing says where they are long.
TEST(BsdfBrushed, NeedsTangents) {
  Plane plane(brushed(metal(0.2f), 0.9f)), even(metal(0.2f));
  plane.scene.meshes[0].uv[0].clear();
  const Vec3 wo = direction(30), wi = direction(40, 2);
  EXPECT_EQ(plane.bsdf(wo).eval(wi, kAllLobes, Transport::flux), even.bsdf(wo).eval(wi, kAllLobes, Transport::flux));
}

// Brushed in one direction alone is no mirror.
TEST(BsdfBrushed, IsNeverSmooth) {
  const Plane plane(brushed(metal(0), 0.5f));
  EXPECT_EQ(plane.bsdf({0, 0, 1}).delta_lobes(), kNoLobe);
  EXPECT_NEAR(albedo(plane.bsdf(direction(40)), Transport::flux).mean, 0.9369, 0.005);   // by quadrature
}

// A smooth coat reflects by Fresnel's law, and the mirror below loses as much.
TEST(BsdfEnergy, ClearcoatTakesItsShareOfWhatIsBelow) {
  const Plane setup(coated(test::mirror(Rgb(0.5f)), 0, 0.8f));
  const Bsdf bsdf = setup.bsdf(direction(60));
  const double fresnel = 0.8 * (0.04 + 0.96 * std::pow(0.5, 5));
  EXPECT_EQ(bsdf.delta_lobes(), kReflectionLobe | kClearcoatLobe);
  EXPECT_TRUE(agrees(albedo(bsdf, Transport::flux), fresnel + (1 - fresnel) * 0.5));
}

// Glass below it loses nothing on the way in, whatever side of a thin sheet is seen, and on the way out what cannot leave.
TEST(BsdfEnergy, ClearcoatOverGlass) {
  for (const float degrees : {0.0f, 70.0f}) {
    EXPECT_TRUE(agrees(albedo(Plane(coated(test::glass(1.5f), 0)).bsdf(direction(degrees)), Transport::flux), 1));
    const Plane thin(coated(rough_glass(0, true), 0), false);
    EXPECT_TRUE(agrees(albedo(thin.bsdf(direction(degrees)), Transport::flux), 1));
  }
  const Plane inside(coated(test::glass(1.5f), 0), false);
  EXPECT_TRUE(agrees(albedo(inside.bsdf({0, 0, 1}), Transport::flux), 0.04 + 0.96 * 0.96));
}

TEST(BsdfEnergy, NothingReflectsMoreThanItGets) {
  for (const Material& m : {metal(0.1f), metal(0.5f), metal(1), rough_glass(0.5f, false), rough_glass(0.5f, true),
                            mixed(), coated(metal(1), 0.2f), coated(mixed(), 0.8f), sheened(metal(0.5f), 0.3f),
                            coated(sheened(mixed(), 0.6f, Rgb(1)), 0.8f), brushed(metal(0.3f), 1),
                            brushed(rough_glass(0.3f, false), 0.8f)}) {
    for (const bool front : {true, false}) {
      const Plane setup(m, front);
      const Sample a = albedo(setup.bsdf(direction(50)), Transport::flux);
      EXPECT_LT(a.mean, 1 + 4 * a.standard_error());
      EXPECT_GT(a.mean, 0.3);
    }
  }
}

TEST(BsdfReciprocity, OpaqueLobesAreSymmetric) {
  for (const Material& m : {test::lambert(Rgb(0.5f)), plastic(0.3f), plastic(1), metal(0.6f), mixed(),
                            coated(test::lambert(Rgb(0.5f)), 0), coated(plastic(0.5f), 0.7f), coated(metal(0.6f), 0.4f),
                            sheened(test::lambert(Rgb(0.5f)), 0), sheened(plastic(0.5f), 0.5f),
                            sheened(metal(0.6f), 0.9f), coated(sheened(mixed(), 0.4f), 0.5f), brushed(metal(0.5f), 0.9f),
                            brushed(mixed(), 0.7f)}) {
    const Plane setup(m);
    for (const float degrees : {10.0f, 40.0f, 70.0f}) {
      const Vec3 a = direction(degrees);
      const Vec3 b = direction(55, 2.5f);
      const Rgb forth = setup.bsdf(a).eval(b, kAllLobes, Transport::radiance);
      const Rgb back = setup.bsdf(b).eval(a, kAllLobes, Transport::radiance);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(forth[c], back[c], 1e-4f * forth[c]);
    }
  }
}

// f(o→i)/η_i² = f(i→o)/η_o² for refraction [Veach 1997, eq. 5.14].
TEST(BsdfReciprocity, RoughRefractionIsSymmetricUpToTheIndex) {
  for (const Material& m : {rough_glass(0.7f, false), coated(rough_glass(0.7f, false), 0.3f),
                            sheened(rough_glass(0.7f, false), 0.6f), along(brushed(rough_glass(0.6f, false), 0.5f))}) {
    const Plane outside(m, true);
    const Plane inside(m, false);
    const Vec3 out = direction(40);
    const Vec3 in = -direction(30, 0.9f);
    const float forth = outside.bsdf(out).eval(in, kGlassLobe, Transport::radiance).x;
    // Seen from inside, the local frame points inwards: mirror both directions.
    const float back = inside.bsdf(-in).eval(-out, kGlassLobe, Transport::radiance).x;
    EXPECT_GT(forth, 0);
    EXPECT_NEAR(forth * 1.5f * 1.5f, back, 1e-3f * back);
  }
}

TEST(BsdfContinuity, RoughnessApproachesTheMirror) {
  const Plane smooth(metal(0));
  const Plane rough(metal(0.011f));   // α just above the smooth limit
  const Sample a = albedo(smooth.bsdf(direction(40)), Transport::flux, 1000);
  const Sample b = albedo(rough.bsdf(direction(40)), Transport::flux, 1000);
  EXPECT_NEAR(a.mean, b.mean, 1e-3);
}

TEST(Microfacet, NormalsProjectToOne) {
  for (const float alpha : {0.05f, 0.3f, 1.0f}) {
    const Sample s = draw(400'000, [&](Rng& rng) {
      // Uniform over the hemisphere, density 1/(2π), in z² to reach the peak.
      const float u = rng.next();
      const float z = 1 - u * u * u;
      const float r = std::sqrt(std::max(0.0f, 1 - z * z));
      const double density = 1 / (2 * kPi * 3.0 * u * u);
      return static_cast<double>(Ggx(alpha).d({r, 0, z}) * z) / density;
    });
    EXPECT_TRUE(agrees(s, 1)) << alpha << " " << s.mean;
  }
}

// The same along and across; the ellipse of normals of equal density is as long as the ratio of both.
TEST(Microfacet, AnisotropicNormalsProjectToOne) {
  const Ggx facets(0.4f, 0.1f);
  const Sample s = draw(400'000, [&](Rng& rng) {
    const Vec2 u = rng.next2();
    const float z = 1 - u.x * u.x * u.x, r = std::sqrt(std::max(0.0f, 1 - z * z));
    const double density = 1 / (2 * kPi * 3.0 * u.x * u.x);
    return static_cast<double>(facets.d({r * std::cos(2 * kPi * u.y), r * std::sin(2 * kPi * u.y), z}) * z) / density;
  });
  EXPECT_TRUE(agrees(s, 1)) << s.mean;
  // Slopes alike in units of α; D cos⁴ is the density of slopes.
  const auto slopes = [&](float x, float y) {
    const Vec3 h = glm::normalize(Vec3(x, y, 1));
    return facets.d(h) * h.z * h.z * h.z * h.z;
  };
  EXPECT_NEAR(slopes(0.4f, 0), slopes(0, 0.1f), 1e-4f * slopes(0, 0.1f));
  EXPECT_NEAR(Ggx(0.3f, 0.3f).d({0.6f, 0, 0.8f}), Ggx(0.3f).d({0, 0.6f, 0.8f}), 1e-6f);
}

TEST(Microfacet, FresnelMatchesTheNormalAndTheCriticalAngle) {
  float cos_t = 0;
  EXPECT_NEAR(fresnel_dielectric(1, 1.5f, cos_t), 0.04f, 1e-6f);
  EXPECT_NEAR(fresnel_dielectric(1, 1 / 1.5f, cos_t), 0.04f, 1e-6f);
  const float critical = std::sqrt(1 - 1 / (1.5f * 1.5f));
  EXPECT_EQ(fresnel_dielectric(critical - 1e-3f, 1 / 1.5f, cos_t), 1);
  EXPECT_LT(fresnel_dielectric(critical + 1e-3f, 1 / 1.5f, cos_t), 1);
}

// f·cos over the hemisphere, of some lobes.
double reflected(const Bsdf& bsdf, LobeMask lobes) {
  constexpr int kHeights = 800, kTurns = 800;
  double sum = 0;
  for (int i = 0; i < kHeights; ++i) {
    for (int k = 0; k < kTurns; ++k) {
      const float z = (static_cast<float>(i) + 0.5f) / kHeights, phi = 2 * kPi * (static_cast<float>(k) + 0.5f) / kTurns;
      const float r = std::sqrt(1 - z * z);
      sum += static_cast<double>(bsdf.eval({r * std::cos(phi), r * std::sin(phi), z}, lobes, Transport::flux).x * z);
    }
  }
  return sum * 2 * static_cast<double>(kPi) / (kHeights * kTurns);
}

// Photons that go on as caustic ones carry what gloss scatters, the others what the base does, however they were drawn.
TEST(Gathered, SettledLobesCarryTheirOwnLight) {
  for (const float height : {0.15f, 0.5f, 1.0f}) {
    const Plane plane(plastic(0.45f, Rgb(0.8f)));
    const Bsdf bsdf(plane.scene, plane.surface, {std::sqrt(1 - height * height), 0, height});
    const LobeMask gathered = gathered_lobes(bsdf);
    ASSERT_EQ(gathered, kDiffuseLobe);
    for (const bool wanted : {false, true}) {
      const Sample carried = draw(400'000, [&](Rng& rng) {
        const Vec2 u = rng.next2();
        auto sample = bsdf.sample({u, rng.next()}, kAllLobes, Transport::flux);
        if (!sample) return 0.0;
        const bool by_gathered = settle_gathered(bsdf, gathered, rng, *sample);
        return by_gathered == wanted ? static_cast<double>(sample->weight.x) : 0.0;
      });
      const double expected = reflected(bsdf, wanted ? kDiffuseLobe : kReflectionLobe);
      EXPECT_TRUE(agrees(carried, expected)) << height << ' ' << wanted << ": " << carried.mean << " of " << expected;
    }
  }
}

}  // namespace
}  // namespace photond
