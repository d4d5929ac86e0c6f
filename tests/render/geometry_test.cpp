// Geometry as modellers leave it: gaps and doubles, slivers, normals that point anywhere.
#include <gtest/gtest.h>

#include "core/scene/gltf.h"
#include "tests/render/look.h"
#include "tests/support/glb.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

using namespace test;

std::string reasons(const Plan& plan) {
  std::string all;
  for (const PlanItem& item : plan.items) all += item.reason + "\n";
  return all;
}

// Nothing to gather at, nothing to gather, nothing at all: every method ends, and the plan says what is
// missing.
TEST(HardCase, NothingToDo18) {
  HardCase c(18, "scenes without receivers, lights or surfaces");
  Scene mirrors = empty_scene();
  add_mesh(mirrors, box({-1, -1, -1}, {1, 1, 1}, true), add_material(mirrors, mirror(Rgb(1))));
  add_point_light(mirrors, {0.1f, 0.2f, 0.3f}, Rgb(1));
  Scene dark = empty_scene();
  add_mesh(dark, box({-1, -1, -1}, {1, 1, 1}), add_material(dark, lambert(Rgb(1))));
  Scene empty = empty_scene();
  add_point_light(empty, {0, 0, 0}, Rgb(1));
  struct Kind {
    const char* what;
    Scene scene;
    const char* message;
  };
  Kind kinds[] = {{"mirror box", mirrors, "no surface gathers photons"},
                  {"no light", dark, "nothing shines"},
                  {"no surfaces", empty, "no surface"}};
  for (Kind& kind : kinds) {
    const auto room = prepared(std::move(kind.scene));
    look_at_with(c.equals(std::string("radiance, ") + kind.what, 0, {.precision = 0}), room,
                 {.from = {0.3f, 0.2f, 0.7f}, .photons = 500, .passes = 2, .side = 2});
    const auto maps = shoot_maps(*room, 500, 1);
    c.equals(std::string("photons stored, ") + kind.what, 0)
        .add("", maps->global.size() + maps->caustic.size());
    const auto plan = make_plan(*room, {}, Execution{});
    ASSERT_TRUE(plan.ok());
    EXPECT_NE(reasons(*plan).find(kind.message), std::string::npos) << reasons(*plan);
  }
}

// The ground is a hundred kilometres wide; a sheet a millimetre above it keeps the sun from it.
TEST(LevelGround, IsDarkBelowWhatLiesOnIt) {
  Scene scene = empty_scene();
  const std::uint32_t white = add_material(scene, lambert(Rgb(0.5f)));
  add_mesh(scene, parallelogram({-5e4f, 0, 5e4f}, {1e5f, 0, 0}, {0, 0, -1e5f}), white);
  add_mesh(scene, parallelogram({-1, 1e-3f, 1}, {2, 0, 0}, {0, 0, -2}), white);
  PunctualLight sun;
  sun.type = LightType::directional;
  sun.direction = glm::normalize(Vec3(0.1f, -1, 0.2f));
  sun.intensity = Rgb(1);
  scene.lights.push_back(sun);
  const auto room = prepared(std::move(scene));
  for (const Method method : kMethods) {
    const Look look{.from = {0, 5e-4f, 0}, .at = {0.05f, 0, 0}, .photons = 2000, .passes = 2, .side = 4};
    EXPECT_NEAR(see(room, method, 1, look)[0].mean, 0, 1e-3) << method_name(method);
  }
}

// One face of a box as a fan of needles a metre long and a micrometre wide (and the rest), seen from a corner.
Mesh needle_box(const glm::mat3& rotation, const Vec3& center) {
  Mesh mesh = box({0, 0, 0}, {1, 1, 1}, true);
  // The face x = 1 (its corners 1, 3, 7, 5) becomes a fan around corner 1 = (1,0,0) over the edge 3–7 at y = 1;
  // the neighbouring faces keep their long edges, so that the fan's vertices are T-junctions.
  std::erase_if(mesh.triangles, [&](const glm::uvec3& t) {
    return mesh.positions[t.x].x + mesh.positions[t.y].x + mesh.positions[t.z].x == 3;
  });
  const auto vertex = [&](float z) {
    mesh.positions.push_back({1, 1, z});
    return static_cast<std::uint32_t>(mesh.positions.size() - 1);
  };
  std::uint32_t last = 3;
  for (int i = 1; i <= 2000; ++i) {
    const std::uint32_t next = vertex(0.5f + 1e-6f * static_cast<float>(i));
    mesh.triangles.push_back({1, next, last});
    last = next;
  }
  mesh.triangles.push_back({1, 7, last});
  mesh.triangles.push_back({1, 5, 7});
  for (Vec3& p : mesh.positions) p = rotation * (p - Vec3(0.5f)) + center;
  return mesh;
}

glm::mat3 some_rotation() {
  const Vec3 x = glm::normalize(Vec3(1, 2, -0.7f));
  const Vec3 y = glm::normalize(glm::cross(Vec3(0.3f, -0.2f, 1), x));
  return {x, y, glm::cross(x, y)};
}

TEST(HardCaseStatistical, Needles21) {
  HardCase c(21, "needles of aspect 10⁶, sliver fan, T-junctions");
  Quantity& q = c.at_most("leak of a closed box, share of the hits", 1e-6);
  double hits = 0, leaks = 0;
  for (const Vec3& center : {Vec3(0), Vec3(30, -20, 10)}) {
    Scene scene = empty_scene();
    add_mesh(scene, needle_box(some_rotation(), center), add_material(scene, lambert(Rgb(0.9f))));
    add_point_light(scene, center + some_rotation() * Vec3(0.2f, 0.1f, -0.1f), Rgb(1));
    const auto room = prepared(std::move(scene));
    for (const std::uint64_t seed : kSeeds) {
      const auto maps = shoot_maps(*room, 200'000, seed);
      hits += static_cast<double>(maps->rays);
      leaks += maps->ledger.escaped / maps->ledger.emitted * maps->emitted;
    }
  }
  q.add("two places, seeds 1 and 2", leaks / hits);   // of some four million hits: one run's million would be too few
}

// Walls that lie twice in the same place, shine once: L = Le/(1 − a).
TEST(HardCase, Doubles22) {
  HardCase c(22, "coincident and degenerate triangles");
  Material wall = emitter(Rgb(1));
  wall.base_color = Rgb(0.5f);
  const Look look{.from = {0.1f, 0.2f, 0.3f},
                  .at = {0.3f, -0.8f, 0.45f},
                  .radius = 0.2f,
                  .photons = 5'000,
                  .passes = 60,
                  .side = 24};
  std::vector<Method> exact = kMethods;
  std::erase(exact, Method::photon_map);  // gathers in corners; nothing of it depends on doubles
  const auto room = [&](int kind) {
    Scene scene = empty_scene();
    const std::uint32_t material = add_material(scene, wall);
    Mesh walls = box({-1, -1, -1}, {1, 1, 1}, true);
    if (kind == 0) {  // every triangle twice, the second time from another corner
      const auto once = walls.triangles;
      for (const glm::uvec3& t : once) walls.triangles.push_back({t.y, t.z, t.x});
    }
    add_mesh(scene, walls, material);
    if (kind == 1) add_mesh(scene, walls, material);               // the mesh twice
    if (kind == 2) scene.instances.push_back(scene.instances[0]);  // placed twice
    if (kind == 3) add_mesh(scene, box({-1, -1, -1}, {1, 1, 1}), add_material(scene, lambert(Rgb(0.5f))));
    return prepared(std::move(scene));
  };
  look_at_with(c.equals("L/Le in a furnace, every triangle twice", 2), room(0), look, exact);
  look_at_with(c.equals("L/Le in a furnace, two equal meshes", 2), room(1), look, exact);
  look_at_with(c.equals("L/Le in a furnace, one mesh placed twice", 2), room(2), look, exact);
  // Of two coincident faces a ray finds one or the other: dark backs show, but nothing gets through.
  Quantity& leak = c.at_most("leak through walls with opposite coincident faces", 0);
  const auto walls = room(3);
  for (const std::uint64_t seed : kSeeds)
    leak.add("seed " + std::to_string(seed), shoot_maps(*walls, 50'000, seed)->ledger.escaped);
}

// Glass that stands exactly on the floor of a furnace, and a liquid that touches its glass: a ray that jumps over what it
// touches leaves the furnace, or takes glass for the liquid. L = Le/(1 − a), and that of the sky.
TEST(HardCase, TouchingGlass22) {
  HardCase c(22, "coincident and degenerate triangles");
  Scene room = empty_scene();
  Material wall = emitter(Rgb(1));
  wall.base_color = Rgb(0.5f);
  add_mesh(room, box({-1, -1, -1}, {1, 1, 1}, true), add_material(room, wall));
  add_mesh(room, box({-0.4f, -1, -0.4f}, {0.4f, -0.5f, 0.4f}), add_material(room, glass(1.5f)));
  const Look down{.from = {0.2f, 0.5f, 0.3f}, .at = {0, -0.9f, 0}, .photons = 20'000, .passes = 60, .side = 16};
  std::vector<Method> exact = kMethods;
  std::erase(exact, Method::photon_map);   // its estimate looks beyond the borders of the glass
  look_at_with(c.equals("L/Le through glass that stands on the floor of a furnace", 2), prepared(std::move(room)), down, exact);

  Scene sky = empty_scene();
  sky.environment.radiance = Rgb(1);
  add_mesh(sky, box({-1, 0, -1}, {1, 0.2f, 1}), add_material(sky, glass(1.5f)));
  add_mesh(sky, box({-1, -0.3f, -1}, {1, 0, 1}), add_material(sky, glass(1.33f)));
  look_at_with(c.equals("L/Le through liquid that touches its glass", 1), prepared(std::move(sky)),
               {.from = {0, 2, 0.8f}, .at = {0, 0, 0}, .photons = 1000, .passes = 40, .side = 8});
}

TEST(HardCase, DegenerateTriangles22) {
  HardCase c(22, "coincident and degenerate triangles");
  GlbDraft draft;
  const int positions =
      draft.add_accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0, 1, 0, 0, 1, 0, 0}, 5126, "VEC3", 3);
  const int indices = draft.add_accessor<std::uint32_t>({0, 1, 2, 0, 1, 3, 1, 4, 5}, 5125, "SCALAR", 1);
  draft.json["meshes"][0]["primitives"][0] = {{"attributes", {{"POSITION", positions}}}, {"indices", indices}};
  const auto scene = read_gltf(draft.pack(), no_resources());
  ASSERT_TRUE(scene.ok());
  c.equals("triangles kept of one good, one flat, one point", 1)
      .add("", static_cast<double>(scene->meshes[0].triangles.size()));
  EXPECT_NE(std::find_if(scene->warnings.begin(), scene->warnings.end(),
                         [](const std::string& w) {
                           return w.find("2 degenerate triangles dropped") != std::string::npos;
                         }),
            scene->warnings.end());
  GlbDraft broken;
  const int nan = broken.add_accessor<float>({0, 0, 0, 1, 0, std::nanf(""), 0, 1, 0}, 5126, "VEC3", 3);
  broken.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = nan;
  const auto refused = read_gltf(broken.pack(), no_resources());
  c.equals("files with a NaN vertex accepted", 0).add("", refused.ok());
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().where, "");
}

// White bodies in a sky vanish whatever their normals say about their sides.
TEST(HardCase, InvertedNormals23) {
  HardCase c(23, "normals inverted, mirrored or far off");
  const Look look{.from = {3, 2, 4}, .photons = 500, .passes = 40, .side = 48};
  Scene inverted = empty_scene();
  inverted.environment.radiance = Rgb(1);
  Mesh body = sphere({0, 0, 0}, 1, 64);
  for (Vec3& n : body.normals) n = -n;
  add_mesh(inverted, body, add_material(inverted, lambert(Rgb(1))));
  look_at_with(c.equals("L/Le of a white sphere with normals inwards", 1), prepared(std::move(inverted)), look);

  // A box that shines outwards by its winding, placed by transforms that mirror and stretch, once and twice:
  // the floor below receives the form factor of a box face, the same as from the box written out.
  const auto lit = [](bool placed, int times) {
    Scene scene = empty_scene();
    add_mesh(scene, parallelogram({-9, -9, 0}, {18, 0, 0}, {0, 18, 0}),
             add_material(scene, lambert(Rgb(0.5f))));
    const std::uint32_t lamp = add_material(scene, emitter(Rgb(2)));
    add_mesh(scene, placed ? box({-1, -1, -1}, {1, 1, 1}) : box({-0.5f, -0.25f, 0.75f}, {0.5f, 0.25f, 1.25f}),
             lamp);
    if (placed) {
      Affine m(1);
      m[0].x = -0.5f, m[1].y = 0.25f, m[2].z = 0.25f;
      m[3] = {0, 0, 1};
      scene.instances.back().to_world = m;
      if (times == 2) {  // far away, so that only sharing the mesh differs
        m[3] = {0, 1e4f, 1e4f};
        scene.instances.push_back({scene.instances.back().mesh, m});
      }
    }
    return prepared(std::move(scene));
  };
  const Look below{.from = {0.5f, 0, 0.3f}, .at = {0.1f, 0, 0}, .photons = 500, .passes = 60, .side = 48};
  // The rectangle 1 × ½ at height ¾, as four rectangles with a corner above the point (.1, 0).
  double e = 0;
  for (const double a : {0.4, 0.6}) {
    const double x = a / 0.75, y = 0.25 / 0.75;
    e += 2 * 1.0 *
         (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
          y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y)));
  }
  const double l = 0.5 / static_cast<double>(kPi) * e;
  look_at_with(c.equals("L by a lamp placed by a mirroring, stretching transform", l), lit(true, 1), below);
  look_at_with(c.equals("L by the same lamp, its mesh shared", l, {.relative = 1e-4}), lit(true, 2), below);
  look_at_with(c.equals("L by the lamp written out", l), lit(false, 1), below);
}

// Where the shading normal leans by β, the cosine lobe around it ends at the true horizon: of albedo a
// ∫ cos⁺ over the upper half is left, L = a Le (1 + cos β)/2. A deviation that is known, and never a gain.
TEST(HardCase, LeaningNormals23) {
  HardCase c(23, "normals inverted, mirrored or far off");
  for (const float degrees : {30.0f, 80.0f}) {
    Scene scene = empty_scene();
    scene.environment.radiance = Rgb(1);
    Mesh plate = parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    const float beta = degrees * kPi / 180;
    plate.normals.assign(4, {std::sin(beta), 0, std::cos(beta)});
    add_mesh(scene, plate, add_material(scene, lambert(Rgb(1))));
    look_at_with(
        c.equals("furnace with normals " + std::to_string(static_cast<int>(degrees)) + "° off: (1 + cos β)/2",
                 (1 + std::cos(static_cast<double>(beta))) / 2),
        prepared(std::move(scene)), {.from = {1, 0.1f, 2}, .photons = 500, .passes = 60, .side = 32});
  }
  // On the photons' way the adjoint factor is bounded: a white tub of leaning normals in a sky may lose light
  // but gives back no more than eight times what meets it, and on the whole no more than there is.
  Scene scene = empty_scene();
  scene.environment.radiance = Rgb(1);
  Mesh ball = sphere({0, 0, 0}, 1, 24);
  Rng rng(23, RngPurpose::pilot, 23, 0);
  for (Vec3& n : ball.normals) n = glm::normalize(n + 2.0f * (Vec3(rng.next(), rng.next(), rng.next()) - 0.5f));
  add_mesh(scene, inside_out(ball), add_material(scene, lambert(Rgb(0.5f))));
  add_point_light(scene, {0, 0.1f, 0.2f}, Rgb(1));
  const auto room = prepared(std::move(scene));
  const double start = room->lights.total_power();
  Quantity& q = c.at_most("largest photon over Φ/n on random normals", 8 * 2);
  for (const std::uint64_t seed : kSeeds) {
    const auto maps = shoot_maps(*room, 20'000, seed);
    double largest = 0;
    for (std::uint32_t i = 0; i < maps->global.size(); ++i)
      largest = std::max(largest, static_cast<double>(maps->global.flux(i).x));
    q.add("seed " + std::to_string(seed), largest / start);
  }
}

// A sun along the floor lights a wall whose normals lean up by β; paths from the floor see it from below the horizon of
// those normals, too, which are then bent until they see it at grazing incidence. The floor is dark: what it sends back
// is less than 10⁻⁴ of all.
TEST(HardCase, WallsOfLeaningNormals23) {
  HardCase c(23, "normals inverted, mirrored or far off");
  constexpr float kHalf = 2, kHeight = 2, kWall = 0.8f, kFloor = 0.001f;
  const Vec3 at(1, 0, 0), towards_sun(1, 0, 0), wall_ng(1, 0, 0);
  for (const float degrees : {20.0f, 60.0f}) {
    const float beta = degrees * kPi / 180;
    const Vec3 leaning(std::cos(beta), 0, std::sin(beta));
    Scene scene = empty_scene();
    add_mesh(scene, parallelogram({0, -kHalf, 0}, {3, 0, 0}, {0, 2 * kHalf, 0}),
             add_material(scene, lambert(Rgb(kFloor))));
    Mesh wall = parallelogram({0, -kHalf, 0}, {0, 2 * kHalf, 0}, {0, 0, kHeight});
    wall.normals.assign(4, leaning);
    add_mesh(scene, wall, add_material(scene, lambert(Rgb(kWall))));
    PunctualLight sun;
    sun.type = LightType::directional;
    sun.direction = -towards_sun;
    sun.intensity = Rgb(1);
    scene.lights.push_back(sun);
    double e = 0;   // ∫ L cos cos / r² over the wall
    constexpr int kSteps = 1000;
    const double area = 2.0 * kHalf * kHeight / (kSteps * kSteps);
    for (int i = 0; i < kSteps * kSteps; ++i) {
      const Vec3 from(0, 2 * kHalf * ((static_cast<float>(i % kSteps) + 0.5f) / kSteps) - kHalf,
                      kHeight * ((static_cast<float>(i / kSteps) + 0.5f) / kSteps));
      const Vec3 way = at - from, out = glm::normalize(way);
      const float cosine = std::max(glm::dot(shading_normal(leaning, wall_ng, out), towards_sun), 0.0f);
      e += static_cast<double>(kWall * kInvPi * cosine * out.x * -out.z / glm::dot(way, way)) * area;
    }
    // Within the radius the irradiance bends by some parts in a thousand.
    look_at_with(c.equals("L of a floor beside a wall with normals " + std::to_string(static_cast<int>(degrees)) + "° off",
                          e * static_cast<double>(kFloor * kInvPi), {.relative = 4e-3}),
                 prepared(std::move(scene)),
                 {.from = {1.5f, 0.1f, 2}, .at = at, .radius = 0.25f, .photons = 100'000, .passes = 80, .side = 48},
                 {Method::path, Method::progressive, Method::hybrid});
  }
}

// Glass and mirrors lose nothing, whatever their normals say: in a white sky they show the sky, mirrors by their colour.
TEST(HardCase, LeaningNormalsOfGlass23) {
  HardCase c(23, "normals inverted, mirrored or far off");
  for (const float degrees : {30.0f, 60.0f}) {
    for (const bool clear : {true, false}) {
      Scene scene = empty_scene();
      scene.environment.radiance = Rgb(1);
      const Mesh sharp = box({-1, -1, -0.1f}, {1, 1, 0.1f});
      Mesh pane;
      for (const glm::uvec3& t : sharp.triangles) {
        const Vec3 corners[] = {sharp.positions[t.x], sharp.positions[t.y], sharp.positions[t.z]};
        const Vec3 across = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
        const Vec3 leaning = glm::normalize(across) + std::tan(degrees * kPi / 180) * Vec3(0.6f, 0.8f, 0);
        const auto first = static_cast<std::uint32_t>(pane.positions.size());
        pane.positions.insert(pane.positions.end(), std::begin(corners), std::end(corners));
        pane.normals.insert(pane.normals.end(), 3, glm::normalize(leaning));
        pane.triangles.push_back({first, first + 1, first + 2});
      }
      add_mesh(scene, pane, add_material(scene, clear ? glass(1.5f) : mirror(Rgb(0.8f))));
      Quantity& q = c.equals((clear ? "L/Le through a pane of glass with normals " : "L/Le off a mirror of .8 with normals ") +
                                 std::to_string(static_cast<int>(degrees)) + "° off",
                             clear ? 1 : 0.8, {.relative = 0.001});   // what is reflected thrice is rarely followed
      const auto sky = prepared(std::move(scene));
      for (const Vec3& from : {Vec3(1.2f, 1.6f, 1), Vec3(-1.2f, -1.6f, 1), Vec3(1.6f, -1.2f, 1)}) {
        look_at_with(q, sky, {.from = from, .photons = 500, .passes = 20, .side = 16});
      }
    }
  }
}

}  // namespace
}  // namespace photond
