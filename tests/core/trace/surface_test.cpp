#include "core/trace/surface.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "core/math/frame.h"
#include "core/math/warp.h"
#include "core/trace/coverage.h"
#include "core/trace/prepare.h"
#include "tests/support/scenes.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

// The same sphere placed once (moved into the world) and twice (instanced).
std::shared_ptr<const PreparedScene> placed(const Affine& to_world, bool instanced) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::sphere({0, 0, 0}, 1), test::add_material(scene, test::lambert(Rgb(0.5f))));
  scene.instances[0].to_world = to_world;
  if (instanced) scene.instances.push_back({0, Affine({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 1000})});
  return test::prepared(std::move(scene));
}

const Affine kMirrored({-2, 0, 0}, {0, 0.5f, 0.5f}, {0, -0.7f, 0.7f}, {1, 2, 3});

TEST(Surface, InstancesShadeLikeMeshesInPlace) {
  const auto single = placed(kMirrored, false);
  const auto instanced = placed(kMirrored, true);
  EXPECT_FALSE(single->scene.instances[0].moved);
  EXPECT_TRUE(instanced->scene.instances[0].moved);
  Rng rng(1, RngPurpose::pilot, 0, 0);
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 origin = Vec3(1, 2, 3) + 6.0f * square_to_sphere(rng.next2());
    const Vec3 target = Vec3(1, 2, 3) + 0.8f * square_to_sphere(rng.next2());
    const Ray ray{origin, glm::normalize(target - origin)};
    const Hit a = single->accel.intersect(ray);
    const Hit b = instanced->accel.intersect(ray);
    if (!a.found() || !b.found()) continue;  // grazing rays may fall to either side of an edge
    ++hits;
    const SurfacePoint s = make_surface(single->scene, ray, a);
    const SurfacePoint t = make_surface(instanced->scene, ray, b);
    EXPECT_LT(glm::distance(s.position, t.position), 2e-4f);
    EXPECT_TRUE(s.front && t.front);   // outside a closed body, mirrored or not
    EXPECT_GT(glm::dot(s.ns, t.ns), 0.999f);
    EXPECT_GT(glm::dot(s.ng, s.ns), 0.9f);
  }
  EXPECT_GT(hits, 500);
}

// Side by side or one by one: the same formulas, so the results differ by the contraction of products and sums only.
TEST(Surface, LanesEqualSinglePoints) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::sphere({0, 0, 0}, 1, 8), test::add_material(scene, test::glass(1.5f)));
  test::add_mesh(scene, test::box({-2, -2, -2}, {2, 2, 2}), test::add_material(scene, test::lambert(Rgb(0.5f))));
  const auto prepared = test::prepared(std::move(scene));
  Rng rng(3, RngPurpose::pilot, 0, 0);
  const auto lanes = std::make_unique<SurfaceLanes>();
  for (int round = 0; round < 100; ++round) {
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      rays.push_back({1.5f * square_to_sphere(rng.next2()), square_to_sphere(rng.next2())});
      if (k % 3 == 0) rays[k].origin *= 0.5f;  // inside the sphere, too
      hits.push_back(prepared->accel.intersect(rays[k]));
      ASSERT_TRUE(hits[k].found());
      const PlacedMesh& mesh = prepared->placed[hits[k].instance];
      EXPECT_TRUE(mesh.in_place);
      lanes->set(k, mesh, hits[k], rays[k].direction);
    }
    lanes->compute(kLanes);
    constexpr float kUlps = 64 * 0x1p-23f;  // a dozen roundings of coordinates up to 2, with room
    for (std::uint32_t k = 0; k < kLanes; ++k) {
      const SurfacePoint s = make_surface(prepared->scene, rays[k], hits[k]);
      const SurfacePoint t = lanes->point(k, prepared->scene, hits[k]);
      EXPECT_LT(glm::distance(s.position, t.position), kUlps);
      EXPECT_LT(glm::distance(s.ng, t.ng), kUlps);
      EXPECT_LT(glm::distance(s.ns, t.ns), kUlps);
      EXPECT_FLOAT_EQ(s.extent, t.extent);
      EXPECT_EQ(s.front, t.front);
      EXPECT_EQ(s.smooth, t.smooth);
      EXPECT_EQ(s.material, t.material);
      EXPECT_EQ(s.vertices, t.vertices);
    }
  }
}

// How many of 20,000 rays that leave a ball meet something within `reach`. They start where rays from `distance` beyond
// its centre meet it, which nearly all do.
int met_again(const PreparedScene& scene, const Vec3& center, float distance, float reach) {
  Rng rng(2, RngPurpose::pilot, 0, 0);
  int again = 0;
  int count = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 origin = center + distance * square_to_sphere(rng.next2());
    const Vec3 local = square_to_cosine_hemisphere(rng.next2());
    const Ray ray{origin, glm::normalize(center - origin)};
    const Hit hit = scene.accel.intersect(ray);
    if (!hit.found()) continue;
    ++count;
    const SurfacePoint s = make_surface(scene.scene, ray, hit);
    Ray out = spawn_ray(s, Frame(s.ng).to_world(local));
    out.t_max = reach;
    again += scene.accel.occluded(out);
  }
  EXPECT_GT(count, 19'900);
  return again;
}

// Rays that leave a convex body never meet it again, wherever and however large it is.
TEST(Surface, SpawnedRaysDoNotHitTheirOwnSurface) {
  for (const float scale : {1e-4f, 1.0f, 1e4f}) {
    for (const float shift : {0.0f, 100.0f}) {
      const Affine m({scale, 0, 0}, {0, scale, 0}, {0, 0, scale}, Vec3(shift * scale));
      const auto scene = placed(m, false);
      EXPECT_EQ(met_again(*scene, Vec3(shift * scale) - scene->scene.origin, 3 * scale, kInfinity), 0)
          << "scale " << scale << " shift " << shift;
    }
  }
}

// Nor where a mesh lies far from where its instances are: the intersection computes with both places.
TEST(Surface, SpawnedRaysDoNotHitInstancesMovedFar) {
  for (const float shift : {100.0f, 10'000.0f}) {
    Scene scene = test::empty_scene();
    const Vec3 away(shift, 0.7f * shift, 0);
    test::add_mesh(scene, test::sphere(away, 1), test::add_material(scene, test::lambert(Rgb(0.5f))));
    scene.instances[0].to_world[3] = -away;
    scene.instances.push_back(scene.instances[0]);
    scene.instances[1].to_world[3] += Vec3(3, 0, 0);
    const auto prepared = test::prepared(std::move(scene));
    ASSERT_TRUE(prepared->scene.instances[0].moved);
    const Vec3 center = prepared->scene.instances[0].to_world[3] + away;
    EXPECT_EQ(met_again(*prepared, center, 1.4f, 0.5f), 0) << "shift " << shift;   // the neighbour is 1 m away
  }
}

TEST(Surface, SingleSidedEmittersAreDarkFromBehind) {
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}),
                 test::add_material(scene, test::emitter(Rgb(3))));
  const auto prepared = test::prepared(std::move(scene));
  for (const float side : {1.0f, -1.0f}) {
    const Ray ray{{0.1f, 0.2f, side}, {0, 0, -side}};
    const SurfacePoint s = make_surface(prepared->scene, ray, prepared->accel.intersect(ray));
    EXPECT_EQ(emitted_radiance(prepared->scene, s), Rgb(side > 0 ? 3.0f : 0.0f));
    EXPECT_FLOAT_EQ(s.ng.z, side);
  }
}

// Whole and partly filled packets find what single rays find.
TEST(Accel, PacketsMeetWhatSingleRaysMeet) {
  const auto room = test::busy_room();
  Rng rng(1, RngPurpose::pilot, 0, 0);
  int found = 0, hidden_rays = 0;
  for (std::uint32_t count = 1; count <= kLanes; ++count) {
    RayLanes rays{};
    HitLanes hits;
    std::uint8_t hidden[kLanes];
    for (std::uint32_t k = 0; k < count; ++k) {
      const Vec3 origin = room->bounds.center() + 0.3f * square_to_sphere(rng.next2());
      rays.set(k, {origin, square_to_sphere(rng.next2()), rng.next() < 0.5f ? kInfinity : room->bounds.radius() / 2});
    }
    for (const Coherence coherence : {Coherence::none, Coherence::high}) {
      room->accel.intersect(rays, count, coherence, hits);
      room->accel.occluded(rays, count, hidden);
      for (std::uint32_t k = 0; k < count; ++k) {
        const Hit hit = room->accel.intersect(rays.ray(k));
        ASSERT_EQ(hits[k].instance, hit.instance);
        EXPECT_EQ(hidden[k] != 0, room->accel.occluded(rays.ray(k)));
        hidden_rays += hidden[k];
        if (!hit.found()) continue;
        ++found;
        EXPECT_EQ(hits[k].triangle, hit.triangle);
        EXPECT_NEAR(hits[k].t, hit.t, 1e-5f * room->bounds.radius());   // some roundings
      }
    }
  }
  EXPECT_GT(found, 100);
  EXPECT_GT(hidden_rays, 100);
}

// A mask of alpha .5: opaque at a cutoff of .4, absent at .6; a blend of .25 stops a quarter of random rays.
TEST(Accel, AlphaDecidesWhatIsHit) {
  const auto share = [](AlphaMode mode, float alpha, float cutoff) {
    Scene scene = test::empty_scene();
    Material m = test::lambert(Rgb(1));
    m.alpha_mode = mode;
    m.alpha = alpha;
    m.alpha_cutoff = cutoff;
    test::add_mesh(scene, test::parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), test::add_material(scene, m));
    const auto prepared = test::prepared(std::move(scene));
    return test::draw(20'000, [&](Rng& rng) {
      const Vec2 p = 1.8f * rng.next2() - 0.9f;
      return prepared->accel.intersect({{p.x, p.y, 1}, {0, 0, -1}}).found() ? 1.0 : 0.0;
    });
  };
  EXPECT_EQ(share(AlphaMode::mask, 0.5f, 0.4f).mean, 1);
  EXPECT_EQ(share(AlphaMode::mask, 0.5f, 0.6f).mean, 0);
  EXPECT_TRUE(test::agrees(share(AlphaMode::blend, 0.25f, 0), 0.25));
}

// Two sheets one behind the other, alike and met at the same places: what one lets through the other halves once more.
TEST(Accel, SheetsAlikeStopLightIndependently) {
  for (const bool shared : {false, true}) {
    Scene scene = test::empty_scene();
    Material half = test::lambert(Rgb(1));
    half.alpha_mode = AlphaMode::blend;
    half.alpha = 0.5f;
    const std::uint32_t material = test::add_material(scene, half);
    const Mesh sheet = test::parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    const std::uint32_t mesh = test::add_mesh(scene, sheet, material);
    if (!shared) test::add_mesh(scene, sheet, material);
    if (shared) scene.instances.push_back({mesh, Affine(1)});
    scene.instances[1].to_world[3].z = 0.5f;
    const auto prepared = test::prepared(std::move(scene));
    double through = 0;
    Rng rng(7, RngPurpose::pilot, 0, 0);
    constexpr int kRays = 20'000;
    for (int i = 0; i < kRays; ++i) {
      const Vec2 at = 2.0f * rng.next2() - 1.0f;
      through += !prepared->accel.intersect({{at, 1}, {0, 0, -1}}).found() / static_cast<double>(kRays);
    }
    EXPECT_NEAR(through, 0.25, 4.1 * std::sqrt(0.25 * 0.75 / kRays)) << shared;
  }
}

TEST(Surface, LookupAppliesTheSlotsTransformAndUvSet) {
  Scene scene;
  scene.images.push_back({.width = 2, .height = 1, .u8 = {0, 0, 0, 255, 255, 255, 255, 255}});
  scene.textures.push_back({.nearest = true});
  Mesh mesh;
  mesh.uv[0].assign(3, {0.75f, 0});
  mesh.uv[1] = {{0.1f, 0}, {0.2f, 0}, {0.3f, 0}};
  SurfacePoint surface{};
  surface.mesh = &mesh;
  surface.vertices = {0, 1, 2};
  surface.u = 0.5f, surface.v = 0.25f;
  TextureSlot slot{.texture = 0, .uv_set = 1};
  EXPECT_FLOAT_EQ(lookup(scene, slot, surface).x, 0);
  slot.uv_transform = glm::mat3x2(1, 0, 0, 1, 0.5f, 0);  // from .2 to .7
  EXPECT_FLOAT_EQ(lookup(scene, slot, surface).x, 1);
  slot = {.texture = 0, .uv_set = 0};
  EXPECT_FLOAT_EQ(lookup(scene, slot, surface).x, 1);
}

// Tangents that a file does not give are the axes of the picture, wherever its transform turns them.
TEST(Surface, NormalTexturesBendTowardsTheTurnedPicturesAxes) {
  const auto bent = [](const glm::mat3x2& transform, bool baked_in) {
    Scene scene = test::empty_scene();
    scene.images.push_back({.width = 1, .height = 1, .u8 = {204, 128, 230, 255}});
    scene.textures.push_back({});
    Material material = test::lambert(Rgb(0.5f));
    material.normal_texture.texture = 0;
    Mesh mesh = test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    auto& uv = mesh.uv[0];
    uv.clear();
    for (const Vec3& p : mesh.positions) uv.emplace_back(p.x, 1 - p.y);
    if (baked_in) {
      for (Vec2& at : uv) at = transform * Vec3(at, 1);
    } else {
      material.normal_texture.uv_transform = transform;
    }
    test::add_mesh(scene, std::move(mesh), test::add_material(scene, material));
    const auto prepared = test::prepared(std::move(scene));
    const Ray ray{{0.3f, 0.4f, 1}, {0, 0, -1}};
    return make_surface(prepared->scene, ray, prepared->accel.intersect(ray)).ns;
  };
  const glm::mat3x2 kinds[] = {{1, 0, 0, 1, 0, 0}, {1, 0, 0, -1, 0, 1}, {-2, 0, 0, 1, 0, 0}, {0, 1, -1, 0, 0, 0}};
  const Vec3 straight = bent(kinds[0], false);
  EXPECT_GT(straight.x, 0.4f);
  for (const glm::mat3x2& transform : kinds) {
    EXPECT_LT(glm::distance(bent(transform, false), bent(transform, true)), 1e-5f);
  }
  EXPECT_GT(glm::distance(bent(kinds[3], false), straight), 0.4f) << "a quarter of a turn";
}

// A coat is as smooth as the mesh where the base is bumpy, or has bumps of its own.
TEST(Surface, ClearcoatsHaveTheirOwnNormals) {
  for (const bool bumpy_coat : {false, true}) {
    Scene scene = test::empty_scene();
    scene.images.push_back({.width = 1, .height = 1, .u8 = {204, 128, 230, 255}});
    scene.textures.push_back({});
    Material material = test::lambert(Rgb(0.5f));
    material.clearcoat = 1;
    (bumpy_coat ? material.clearcoat_normal_texture : material.normal_texture).texture = 0;
    Mesh mesh = test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    mesh.uv[0].clear();
    for (const Vec3& p : mesh.positions) mesh.uv[0].emplace_back(p.x, 1 - p.y);
    test::add_mesh(scene, std::move(mesh), test::add_material(scene, material));
    const auto prepared = test::prepared(std::move(scene));
    const Ray ray{{0.3f, 0.4f, 1}, {0, 0, -1}};
    const SurfacePoint surface = make_surface(prepared->scene, ray, prepared->accel.intersect(ray));
    const Vec3 coat = clearcoat_normal(prepared->scene, surface, -ray.direction);
    EXPECT_TRUE(surface.smooth);
    const Vec3 &bumpy = bumpy_coat ? coat : surface.ns, &flat = bumpy_coat ? surface.ns : coat;
    EXPECT_EQ(flat, Vec3(0, 0, 1));
    EXPECT_NEAR(bumpy.x, 0.6, 0.01);
    EXPECT_NEAR(bumpy.z, 0.8, 0.01);
  }
}

// Transforms apply to coordinates that a mesh does not have, too, whether colour or alpha is looked up.
TEST(Surface, WithoutCoordinatesTheTextureIsReadAtItsTransformedOrigin) {
  Scene scene;
  scene.images.push_back({.width = 2, .height = 1, .u8 = {0, 0, 0, 0, 255, 255, 255, 255}});
  scene.textures.push_back({.nearest = true});
  Material material = test::lambert(Rgb(1));
  material.alpha_mode = AlphaMode::blend;
  material.base_color_texture = {.texture = 0, .uv_transform = glm::mat3x2(1, 0, 0, 1, 0.6f, 0)};
  scene.materials.push_back(material);
  Mesh mesh;
  mesh.triangles = {{0, 1, 2}};
  SurfacePoint surface{};
  surface.mesh = &mesh;
  EXPECT_EQ(lookup(scene, material.base_color_texture, surface).x, 1);
  EXPECT_EQ(coverage(scene, mesh, 0, 0.2f, 0.3f), 1);
}

}  // namespace
}  // namespace photond
