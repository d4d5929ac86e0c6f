// Unequal lights, thin sheets, and numbers that no material should have.
#include <gtest/gtest.h>

#include <numbers>

#include "core/film/film.h"
#include "core/film/reconstruct.h"
#include "core/scene/gltf.h"
#include "tests/render/look.h"
#include "tests/support/glb.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

using namespace test;

constexpr double kPiD = std::numbers::pi;

// Two closed furnaces beside each other, one a million times as bright: the floor of the light choice lets the
// dim one converge too. L = Le/(1 − a).
TEST(HardCaseStatistical, UnequalRooms27) {
  HardCase c(27, "lights of 10⁶ : 1 in separate rooms");
  Scene scene = empty_scene();
  for (const float radiance : {1e6f, 1.0f}) {
    Material wall = emitter(Rgb(radiance));
    wall.base_color = Rgb(0.5f);
    const float x = radiance > 1 ? -2.0f : 2.0f;
    add_mesh(scene, box({x - 1, -1, -1}, {x + 1, 1, 1}, true), add_material(scene, wall));
  }
  const auto rooms = prepared(std::move(scene));
  std::vector<Method> exact = kMethods;
  std::erase(exact, Method::photon_map);  // gathers in corners
  for (const double radiance : {1e6, 1.0}) {
    const float x = radiance > 1 ? -2.0f : 2.0f;
    // A fortieth of the choices falls to the dim room.
    look_at_with(
        c.equals(radiance > 1 ? "L/Le in the bright room" : "L/Le in the dim room", 2, {.precision = 0.02}),
        rooms,
        {.from = {x + 0.1f, 0.2f, 0.3f},
         .at = {x + 0.3f, -1, 0.2f},
         .radius = 0.5f,
         .photons = 40'000,
         .passes = 60,
         .side = 24},
        exact, 1 / radiance);
  }
}

// A plate lit from above by way of a mirror: its lower side is dark, whatever the radius.
TEST(HardCase, TwoSidedSheet42) {
  HardCase c(42, "thin sheets");
  Scene scene = empty_scene();
  add_mesh(scene, parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), add_material(scene, lambert(Rgb(0.5f))));
  add_mesh(scene, parallelogram({-1, -1, 1}, {0, 2, 0}, {2, 0, 0}), add_material(scene, mirror(Rgb(1))));
  PunctualLight spot;
  spot.type = LightType::spot;
  spot.position = {0, 0, 0.5f};
  spot.direction = {0, 0, 1};
  spot.cos_inner = 0.97f;
  spot.cos_outer = 0.95f;
  spot.intensity = Rgb(1);
  scene.lights.push_back(spot);
  const auto room = prepared(std::move(scene));
  Look look{.from = {0, 0, -1}, .photons = 3000, .passes = 60};
  look_at_with(c.equals("L of the dark side", 0, {.precision = 0}), room, look);
  look.from = {0.3f, 0, 0.3f};
  // The virtual light is 1.5 m above; E bends by (r/1.5)² = .4 %·½.
  look_at_with(c.equals("L of the lit side", 0.5 / kPiD / 2.25, {.relative = 0.003, .precision = 0.025}), room,
               look, photon_methods());
}

// A blended sheet before nothing, lit by a floor alone: it shows as much less light as it covers less.
TEST(BlendedSurfaces, ShowPhotonsInProportion) {
  const auto seen = [](float alpha, Method method) {
    Scene scene = empty_scene();
    Material sheet = lambert(Rgb(0.8f));
    sheet.alpha_mode = AlphaMode::blend;
    sheet.alpha = alpha;
    add_mesh(scene, parallelogram({-1, 0.5f, 0}, {2, 0, 0}, {0, 2, 0}), add_material(scene, sheet));
    add_mesh(scene, parallelogram({-2, 0, 3}, {4, 0, 0}, {0, 0, -2.9f}), add_material(scene, lambert(Rgb(0.5f))));
    PunctualLight sun;   // along the sheet
    sun.type = LightType::directional;
    sun.direction = {0, -1, 0};
    sun.intensity = Rgb(1);
    scene.lights.push_back(sun);
    const Look look{.from = {0, 1.2f, 3}, .at = {0, 1.2f, 0}, .radius = 0.3f, .photons = 20'000, .passes = 250};
    return see(prepared(std::move(scene)), method, 1, look)[0];
  };
  const Sample opaque = seen(1, Method::path);
  for (const float alpha : {0.5f, 0.2f}) {
    for (const Method method : kMethods) {
      const Sample blended = seen(alpha, method);
      const double expected = static_cast<double>(alpha) * opaque.mean;
      const double error = std::hypot(blended.standard_error(), static_cast<double>(alpha) * opaque.standard_error());
      // What shines through to and fro between sheet and floor is less than a percent.
      EXPECT_NEAR(blended.mean, expected, 0.02 * expected + kSigmas * error) << method_name(method) << alpha;
      EXPECT_LT(error, 0.1 * expected) << method_name(method) << alpha;
    }
  }
}

// Light through a blended sheet of alpha .3, and through a mask with holes in half of it.
TEST(HardCase, AlphaSheet42) {
  HardCase c(42, "thin sheets");
  Scene scene = empty_scene();
  Material sheet = lambert(Rgb(0));
  sheet.alpha_mode = AlphaMode::blend;
  sheet.alpha = 0.3f;
  add_mesh(scene, parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), add_material(scene, sheet));
  const auto light = [](Scene& s) {
    PunctualLight spot;
    spot.type = LightType::spot;
    spot.position = {0.3f, 0.2f, 0.5f};
    spot.direction = {0, 0, -1};
    spot.cos_inner = 0.999f;
    spot.cos_outer = 0.998f;
    s.lights.push_back(spot);
  };
  light(scene);
  const auto blended = prepared(std::move(scene));

  Scene holes = empty_scene();
  TextureImage image;
  image.width = image.height = 16;
  for (int i = 0; i < 256; ++i)
    image.u8.insert(image.u8.end(),
                    {255, 255, 255, static_cast<std::uint8_t>((i + i / 16) % 2 == 0 ? 255 : 0)});
  holes.images.push_back(image);
  Texture texture;
  texture.nearest = true;
  holes.textures.push_back(texture);
  Material masked = lambert(Rgb(0));
  masked.alpha_mode = AlphaMode::mask;
  masked.base_color_texture.texture = 0;
  masked.base_color_texture.uv_transform = {16, 0, 0, 16, 0, 0};  // checks of 8 mm
  add_mesh(holes, parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), add_material(holes, masked));
  PunctualLight sun;
  sun.type = LightType::directional;
  holes.lights.push_back(sun);
  const auto mask = prepared(std::move(holes));

  Quantity& through = c.equals("photons through a sheet of alpha .3", 0.7);
  // The sun's photons go through the scene's bounds, which are the sheet's.
  Quantity& half = c.equals("photons through a mask with half holes", 0.5);
  for (const std::uint64_t seed : kSeeds) {
    Sample blend, masks;
    for (std::uint32_t pass = 0; pass < 20; ++pass) {
      const EnergyLedger a = shoot_maps(*blended, 5000, seed, pass)->ledger;
      blend.add(a.escaped / a.emitted);
      const EnergyLedger b = shoot_maps(*mask, 5000, seed, pass)->ledger;
      masks.add(b.escaped / b.emitted);
    }
    through.add("seed " + std::to_string(seed), blend);
    half.add("seed " + std::to_string(seed), masks);
  }
}

// A convex body in a closed lamp of alpha .3, and nothing behind it: L = a·.3·Le.
TEST(HardCase, AlphaLamp42) {
  HardCase c(42, "thin sheets");
  Scene scene = empty_scene();
  Material lamp = emitter(Rgb(1));
  lamp.base_color = Rgb(0);
  lamp.alpha_mode = AlphaMode::blend;
  lamp.alpha = 0.3f;
  add_mesh(scene, box({-3, -3, -3}, {3, 3, 3}, true), add_material(scene, lamp));
  add_mesh(scene, box({-1, -1, -1}, {1, 1, 1}), add_material(scene, lambert(Rgb(0.8f))));
  look_at_with(c.equals("L of a white body among lamps of alpha .3", 0.24), prepared(std::move(scene)),
               {.from = {0.3f, 0.2f, 2.5f}, .at = {0.3f, 0.2f, 1}, .photons = 2000, .passes = 40, .side = 32});
}

// A thin-walled pane of index n lets 1 − ((n − 1)/(n + 1))² through, straight on: E = (1 − F) I/h² below it.
TEST(HardCase, TransmittingSheet42) {
  HardCase c(42, "thin sheets");
  Scene scene = empty_scene();
  add_mesh(scene, parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), add_material(scene, lambert(Rgb(1e-3f))));
  Material leaf = glass(1.5f);
  leaf.thin_walled = true;
  leaf.base_color = {0.2f, 0.8f, 0.1f};
  add_mesh(scene, parallelogram({-1, -1, 0.5f}, {2, 0, 0}, {0, 2, 0}), add_material(scene, leaf));
  PunctualLight spot;
  spot.type = LightType::spot;
  spot.position = {0, 0, 1};
  spot.cos_inner = 0.995f;
  spot.cos_outer = 0.99f;
  spot.intensity = Rgb(1);
  scene.lights.push_back(spot);
  // cos³ over the kernel: 1.5·ρ², ⟨ρ²⟩ = r²/3, r = .05: .13 %.
  look_at_with(c.equals("E below a pane of colour .8", 0.8 * 0.96, {.relative = 0.002, .precision = 0.025}),
               prepared(std::move(scene)),
               {.from = {0.2f, 0, 0.2f}, .radius = 0.05f, .photons = 10'000, .passes = 60}, photon_methods(),
               kPiD * 1e3, 1);
}

// What a file may not say is refused where it says it.
TEST(HardCase, AbsurdNumbersInFiles44) {
  HardCase c(44, "absurd numbers");
  Quantity& accepted =
      c.equals("files accepted with an index of −1 or .5, a roughness of 2, a light of −1 or 10³⁹", 0);
  const auto refuse = [&](const char* what, const std::function<void(nlohmann::json&)>& change) {
    GlbDraft draft;
    draft.json["materials"] = {nlohmann::json::object()};
    draft.json["meshes"][0]["primitives"][0]["material"] = 0;
    change(draft.json);
    const auto scene = read_gltf(draft.pack(), no_resources());
    accepted.add(what, scene.ok());
    if (!scene.ok()) {
      EXPECT_NE(scene.error().where, "") << what;
    }
  };
  refuse("ior −1", [](auto& j) { j["materials"][0]["extensions"]["KHR_materials_ior"]["ior"] = -1; });
  refuse("ior .5", [](auto& j) { j["materials"][0]["extensions"]["KHR_materials_ior"]["ior"] = 0.5; });
  refuse("roughness 2", [](auto& j) { j["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 2; });
  refuse("light 1e39", [](auto& j) {
    j["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 1e39}}};
    j["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  });
  refuse("light −1", [](auto& j) {
    j["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", -1}}};
    j["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  });
}

// Index 1 is air: nothing is there. Index 0 stands for an infinite one: all is reflected. In a sky of Le both
// show Le.
TEST(HardCase, LimitsOfTheIndex44) {
  HardCase c(44, "absurd numbers");
  for (const float ior : {1.0f, 0.0f, 1e6f}) {
    Scene scene = empty_scene();
    scene.environment.radiance = Rgb(1);
    add_mesh(scene, sphere({0, 0, 0}, 1), add_material(scene, glass(ior)));
    char what[48];
    std::snprintf(what, sizeof what, "L/Le through a ball of index %g", static_cast<double>(ior));
    // Where smooth glass is followed both ways, what enters an index of a million (4·10⁻⁶ of the light) is lost in it.
    look_at_with(c.equals(what, 1, {.relative = 1e-5}), prepared(std::move(scene)),
                 {.from = {0.4f, 3, 0.1f}, .at = {0.4f, 0, 0.1f}, .photons = 500, .passes = 20});
  }
}

// Rough glass of an index that bends nothing: all light goes through it but for what the facets hide from one another
// at either surface, G₂/G₁ = (1 + Λ)/(1 + 2Λ) [Heitz 2014].
TEST(HardCase, RoughGlassThatBendsNothing44) {
  HardCase c(44, "absurd numbers");
  for (const float roughness : {0.05f, 0.5f, 1.0f}) {
    Scene scene = empty_scene();
    scene.environment.radiance = Rgb(1);
    Material m = glass(1);
    m.roughness = roughness;
    add_mesh(scene, sphere({0, 0, 0}, 1), add_material(scene, m));
    char what[64];
    std::snprintf(what, sizeof what, "L/Le through a ball of index 1 and roughness %g", static_cast<double>(roughness));
    const double alpha_sq = std::pow(static_cast<double>(roughness), 4);
    const double tan_sq = 0.17 / 0.83;   // where the ray through (.4, ., .1) enters and leaves
    const double lambda = 0.5 * (std::sqrt(1 + alpha_sq * tan_sq) - 1);
    const double through = std::pow((1 + lambda) / (1 + 2 * lambda), 2);
    look_at_with(c.equals(what, through, {.relative = 0.003}), prepared(std::move(scene)),
                 {.from = {0.4f, 3, 0.1f}, .at = {0.4f, 0, 0.1f}, .photons = 500, .passes = 20, .side = 16});
  }
}

// A material that is not a number (no file can say it, a program can): its samples are black and counted, the
// rest of the picture stands.
TEST(HardCase, NotANumber44) {
  HardCase c(44, "absurd numbers");
  Quantity& finite = c.equals("pixels that are not finite, with an albedo of NaN or ∞", 0);
  for (const float albedo : {std::nanf(""), kInfinity}) {
    Scene scene = empty_scene();
    scene.environment.radiance = Rgb(1);
    add_mesh(scene, box({-1, -1, -1}, {1, 1, 1}), add_material(scene, lambert(Rgb(albedo))));
    const auto room = prepared(std::move(scene));
    for (const Method method : kMethods) {
      RenderSettings settings;
      settings.method = method;
      settings.width = settings.height = 16;
      settings.radius = 0.1f;
      const auto task = make_render_task(room, room->scene.cameras[0], {2000, 1}, settings, Execution{});
      ASSERT_TRUE(task.ok());
      const MapSource maps = [&](const MapKey& key, const Execution& e) {
        return build_photon_maps(*room, key, e);
      };
      const auto image = render_pass(*task, 0, maps, Execution{});
      ASSERT_TRUE(image.ok());
      double bad = 0;
      Film film(16, 16);
      add_pass(film, 0, *image);
      for (const Rgb& pixel : film_picture(film).pixels) bad += !is_finite(pixel);
      finite.add(method_name(method), bad);
      EXPECT_GT(film.rejected, 0u) << method_name(method);
      const EnergyLedger e = shoot_maps(*room, 2000, 1)->ledger;
      EXPECT_GT(e.rejected, 0);
      EXPECT_NEAR((e.absorbed + e.escaped + e.truncated + e.rejected) / e.emitted, 1, 1e-6);
    }
  }
}

}  // namespace
}  // namespace photond
