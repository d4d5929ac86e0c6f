#include "core/trace/medium.h"

#include <gtest/gtest.h>

#include "core/trace/enclosing.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

Material liquid() {
  Material material = test::glass(1.3f);
  material.attenuation_color = {0.5f, 0.25f, 1};
  material.attenuation_distance = 1;
  return material;
}

// A tank of liquid, a clear marble in it, a drop of liquid in that.
Scene tank() {
  Scene scene = test::empty_scene();
  const std::uint32_t absorbing = test::add_material(scene, liquid());
  const std::uint32_t clear = test::add_material(scene, test::glass(1.5f));
  test::add_mesh(scene, test::box({-4, -4, -4}, {4, 4, 4}), absorbing);
  test::add_mesh(scene, test::box({-2, -2, -2}, {2, 2, 2}), clear);
  test::add_mesh(scene, test::box({-1, -1, -1}, {1, 1, 1}), absorbing);
  return scene;
}

enum class Event { enter, leave, reflect_within };

void follow(Medium& medium, const Scene& scene, std::size_t material, Event event) {
  SurfacePoint surface{};
  surface.material = &scene.materials[material];
  surface.front = event == Event::enter;
  medium.cross(scene, surface, event != Event::reflect_within);
}

TEST(Medium, IsWhatThePathHasEnteredLast) {
  const Scene scene = tank();
  const std::size_t absorbing = scene.meshes[0].material, clear = scene.meshes[1].material;
  const Rgb liquid(0.25f, 0.0625f, 1), none(1);
  Medium medium;
  const auto after = [&](std::size_t material, Event event) {
    follow(medium, scene, material, event);
    return medium.transmittance(scene, 2);
  };
  EXPECT_EQ(after(clear, Event::enter), none);
  EXPECT_FALSE(medium.active()) << "nothing around it absorbs";
  EXPECT_EQ(after(clear, Event::leave), none);
  EXPECT_EQ(after(absorbing, Event::enter), liquid);
  EXPECT_EQ(after(clear, Event::enter), none);
  EXPECT_TRUE(medium.active());
  EXPECT_EQ(after(absorbing, Event::enter), liquid);
  EXPECT_EQ(after(absorbing, Event::reflect_within), liquid);
  EXPECT_EQ(after(absorbing, Event::leave), none);
  EXPECT_EQ(after(clear, Event::leave), liquid) << "the tank is not forgotten";
  EXPECT_EQ(after(absorbing, Event::leave), none);
  EXPECT_FALSE(medium.active());
}

TEST(Medium, IsNoticedByReflectionWithinIt) {
  const Scene scene = tank();
  Medium medium;
  follow(medium, scene, scene.meshes[0].material, Event::reflect_within);
  EXPECT_EQ(medium.transmittance(scene, 1), Rgb(0.5f, 0.25f, 1));
  Medium outside;
  follow(outside, scene, scene.meshes[1].material, Event::reflect_within);
  EXPECT_FALSE(outside.active());
}

TEST(Medium, OutgrowsNothing) {
  const Scene scene = tank();
  Medium medium;
  for (int i = 0; i < 10; ++i) follow(medium, scene, scene.meshes[0].material, Event::enter);
  EXPECT_EQ(medium.transmittance(scene, 1), Rgb(0.5f, 0.25f, 1));
}

// Glass in water in air, one beside the other, and overlapping.
TEST(Medium, KnowsTheIndexAround) {
  Scene scene = test::empty_scene();
  const std::uint32_t water = test::add_material(scene, test::glass(1.25f)), glass = test::add_material(scene, test::glass(1.5f));
  scene.materials[water].nested = scene.materials[glass].nested = true;
  Medium medium;
  const auto index = [&](std::uint32_t material, bool front) {
    SurfacePoint surface{};
    surface.material = &scene.materials[material];
    surface.ior = surface.material->ior;
    surface.front = front;
    return medium.relative_index(scene, surface);
  };
  EXPECT_EQ(index(glass, true), 1.5f);
  EXPECT_EQ(index(glass, false), 1.5f) << "nobody has seen the path enter";
  follow(medium, scene, water, Event::enter);
  EXPECT_EQ(index(water, false), 1.25f);
  EXPECT_EQ(index(glass, true), 1.2f);
  follow(medium, scene, glass, Event::enter);
  EXPECT_EQ(index(glass, false), 1.2f);
  EXPECT_EQ(index(water, false), 1) << "glass is there instead";
  follow(medium, scene, water, Event::leave);
  EXPECT_EQ(index(glass, false), 1.5f);
}

// A shell whose sides have materials of their own, with glass in it.
TEST(Medium, LeavesAShellByItsInnerSide) {
  Scene scene = test::empty_scene();
  const std::uint32_t outer = test::add_material(scene, test::glass(1.5f)), inner = test::add_material(scene, test::glass(1.5f));
  for (const std::uint32_t material : {outer, inner}) scene.materials[material].nested = true;
  Medium medium;
  follow(medium, scene, outer, Event::enter);
  SurfacePoint side{};
  side.material = &scene.materials[inner];
  side.ior = 1.5f;
  side.front = false;
  EXPECT_EQ(medium.relative_index(scene, side), 1.5f);
  follow(medium, scene, inner, Event::leave);
  EXPECT_FALSE(medium.active());
  follow(medium, scene, inner, Event::enter);
  follow(medium, scene, outer, Event::leave);
  EXPECT_FALSE(medium.active());
}

// Only what may reach into another volume.
TEST(Medium, FollowsVolumesThatMayReachIntoOneAnother) {
  const auto nested = [](float x, float size = 1, bool inwards = false) {
    Scene scene = test::empty_scene();
    const std::uint32_t first = test::add_material(scene, test::glass(1.5f)), second = test::add_material(scene, test::glass(1.5f));
    test::add_mesh(scene, test::box({-1, -1, -1}, {1, 1, 1}), first);
    test::add_mesh(scene, test::box({x - size, -size, -size}, {x + size, size, size}, inwards), second);
    const auto prepared = test::prepared(std::move(scene));
    EXPECT_EQ(prepared->scene.materials[second].nested, prepared->scene.materials[first].nested);
    return prepared->scene.materials[first].nested;
  };
  EXPECT_TRUE(nested(1.5f));
  EXPECT_TRUE(nested(2)) << "they touch";
  EXPECT_FALSE(nested(2.5f));
  EXPECT_TRUE(nested(0, 0.5f));
  EXPECT_FALSE(nested(0, 0.5f, true)) << "a shell";
}

// A lamp of one mesh, of which a part hangs in the tank, another in the air.
TEST(Medium, EnclosesEachPartOfALamp) {
  Scene scene = tank();
  Mesh lamp = test::parallelogram({-3, -3, -3}, {0.5f, 0, 0}, {0, 0.5f, 0});
  const Mesh other = test::parallelogram({5, 5, 5}, {0.5f, 0, 0}, {0, 0.5f, 0});
  lamp.positions.insert(lamp.positions.end(), other.positions.begin(), other.positions.end());
  lamp.triangles.insert(lamp.triangles.end(), {{4, 5, 6}, {4, 6, 7}});
  lamp.uv[0].clear();
  test::add_mesh(scene, lamp, test::add_material(scene, test::emitter(Rgb(1))));
  const auto room = test::prepared(std::move(scene));
  ASSERT_EQ(room->light_media.around.size(), 4u);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(room->light_media.around[static_cast<std::size_t>(i)].active(), i < 2) << i;
}

// A triangle that reaches out of the tank, and one that reaches into the marble.
TEST(Medium, EnclosesEachStartOfATriangleThatReachesOut) {
  Scene scene = tank();
  test::add_mesh(scene, test::parallelogram({3, 3, 3}, {4, 0, 0}, {0, 0.5f, 0}), test::add_material(scene, test::emitter(Rgb(1))));
  test::add_mesh(scene, test::parallelogram({1.5f, 0, 0}, {2, 0, 0}, {0, 0.2f, 0}), test::add_material(scene, test::emitter(Rgb(2))));
  test::add_mesh(scene, test::parallelogram({3, -3, 0}, {0.5f, 0, 0}, {0, 0.2f, 0}), test::add_material(scene, test::emitter(Rgb(3))));
  const auto room = test::prepared(std::move(scene));
  EXPECT_EQ(room->light_media.divided, std::vector<bool>({true, true, true, true, false, false}));
  const auto kept = [&](std::uint32_t light, const Vec3& start) {
    return room->light_media.at(room->scene, room->accel, light, start).transmittance(room->scene, 1).x;
  };
  EXPECT_EQ(kept(0, {3.2f, 3.1f, 3.001f}), 0.5f);
  EXPECT_EQ(kept(0, {6, 3.1f, 3.001f}), 1);
  EXPECT_EQ(kept(2, {1.6f, 0.1f, 0.001f}), 1);
  EXPECT_EQ(kept(2, {3, 0.1f, 0.001f}), 0.5f);
  EXPECT_EQ(kept(4, {3.2f, -2.9f, 0.001f}), 0.5f);
}

TEST(Medium, EnclosesWhatLiesWithin) {
  const auto prepared = test::prepared(tank());
  const auto at = [&](const Vec3& point) { return enclosing(prepared->scene, prepared->accel, point); };
  EXPECT_FALSE(at({5, 0, 0}).active());
  EXPECT_EQ(at({3, 0, 0}).transmittance(prepared->scene, 1), Rgb(0.5f, 0.25f, 1));
  EXPECT_EQ(at({1.5f, 0, 0}).transmittance(prepared->scene, 1), Rgb(1));
  EXPECT_TRUE(at({1.5f, 0, 0}).active()) << "in the marble, in the tank";
  EXPECT_EQ(at({0, 0, 0}).transmittance(prepared->scene, 1), Rgb(0.5f, 0.25f, 1));
  EXPECT_TRUE(has_followed_volumes(prepared->scene));
}

TEST(Medium, OfLightsIsKnownWhereAnythingAbsorbs) {
  Scene scene = tank();
  test::add_point_light(scene, {3, 0, 0}, Rgb(1));
  test::add_point_light(scene, {9, 0, 0}, Rgb(1));
  const auto lit = test::prepared(std::move(scene));
  ASSERT_EQ(lit->light_media.around.size(), 2u);
  EXPECT_TRUE(lit->light_media.around[0].active());
  EXPECT_FALSE(lit->light_media.around[1].active());
  Scene clear = test::empty_scene();
  test::add_mesh(clear, test::box({-1, -1, -1}, {1, 1, 1}), test::add_material(clear, test::glass(1.5f)));
  test::add_point_light(clear, {3, 0, 0}, Rgb(1));
  EXPECT_TRUE(test::prepared(std::move(clear))->light_media.around.empty());
}

}  // namespace
}  // namespace photond
