// One scene in other units and other places. Nothing in it knows what a metre is.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/film/reconstruct.h"
#include "core/scene/gltf.h"
#include "tests/render/look.h"
#include "tests/support/glb.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

using namespace test;

// A room with a glass ball, a mirror ball, an area light and a point light, `scale` metres for one, moved by
// `offset` through the transforms of its parts. Radiance stays, intensity goes with the area.
Scene small_room(float scale, const Vec3& offset = Vec3(0)) {
  Scene scene = empty_scene();
  const auto place = [&](Mesh mesh, const Material& material) {
    for (Vec3& p : mesh.positions) p *= scale;
    add_mesh(scene, std::move(mesh), add_material(scene, material));
    scene.instances.back().to_world[3] = offset;
  };
  place(box({-1, -1, -1}, {1, 1, 4}, true), lambert({0.7f, 0.5f, 0.4f}));
  place(sphere({0.4f, -0.5f, 0}, 0.4f), glass(1.5f));
  place(sphere({-0.5f, -0.5f, -0.3f}, 0.4f), mirror(Rgb(0.9f)));
  place(parallelogram({-0.3f, 0.9f, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}), emitter(Rgb(10)));
  add_point_light(scene, offset + scale * Vec3(0.5f, 0.5f, 1), Rgb(0.5f * scale * scale));
  scene.cameras[0] = photond::look_at(offset + scale * Vec3(0, 0, 3), offset, {0, 1, 0}, 0.7f);
  return scene;
}

PassImage first_pass(Scene scene, Method method, std::uint64_t seed) {
  const auto room = prepared(std::move(scene));
  RenderSettings settings;
  settings.method = method;
  settings.width = settings.height = 32;
  settings.seed = seed;
  PhotonSettings photons{20'000, seed};
  const Execution& execution = workers().execution();
  const auto task =
      make_render_task(room, room->scene.cameras[0], photons, settings, execution);  // automatic radius
  EXPECT_TRUE(task.ok());
  const MapSource maps = [&](const MapKey& key, const Execution& e) {
    return build_photon_maps(*room, key, e);
  };
  return *render_pass(*task, 0, maps, execution);
}

Image picture(Scene scene, Method method, std::uint64_t seed) { return first_pass(std::move(scene), method, seed).radiance; }

// With what the bands add.
Image developed(Scene scene, Method method, std::uint64_t seed) {
  const PassImage pass = first_pass(std::move(scene), method, seed);
  Film film(pass.radiance.width, pass.radiance.height);
  add_pass(film, 0, pass);
  EXPECT_EQ(film.rejected, 0u);
  return film_picture(film);
}

// Median over the pixels of |a − b|/b.
double median_difference(const Image& a, const Image& b) {
  std::vector<double> d;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const double base = static_cast<double>(luminance(b.pixels[i]));
    d.push_back(std::abs(static_cast<double>(luminance(a.pixels[i])) - base) / std::max(base, 1e-9));
  }
  std::nth_element(d.begin(), d.begin() + static_cast<std::ptrdiff_t>(d.size() / 2), d.end());
  return d[d.size() / 2];
}

// Pixels of more than 10⁻³ difference, as a share.
double strays(const Image& a, const Image& b) {
  double count = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    count += luminance(glm::abs(a.pixels[i] - b.pixels[i])) > 1e-3f * luminance(b.pixels[i]);
  }
  return count / static_cast<double>(a.pixels.size());
}

// In powers of two every operation rounds alike: a unit hidden anywhere would change bits.
TEST(HardCase, PowersOfTwo19) {
  HardCase c(19, "scale of the scene");
  for (const Method method : kMethods) {
    Quantity& q =
        c.equals(std::string("pixels that differ at scales 2⁻²⁰, 2⁻¹⁴, 2¹⁰, 2²⁰ and 2³⁶, ") + method_name(method), 0);
    for (const std::uint64_t seed : kSeeds) {
      const Image one = developed(small_room(1), method, seed);
      for (const int exponent : {-20, -14, 10, 20, 36}) {
        const Image other = developed(small_room(std::ldexp(1.0f, exponent)), method, seed);
        double differ = 0;
        for (std::size_t i = 0; i < one.pixels.size(); ++i) differ += one.pixels[i] != other.pixels[i];
        q.add(run_name(method, seed) + ", 2^" + std::to_string(exponent), differ);
      }
    }
  }
}

// In other scales the vertices round differently, and where a ray passes an edge of the glass it may go another
// way: such pixels are counted apart. Of the rest the median must not move.
TEST(HardCase, DecimalScales19) {
  HardCase c(19, "scale of the scene");
  for (const float scale : {1e-4f, 1e-2f, 1e3f, 1e6f}) {
    char what[64];
    std::snprintf(what, sizeof what, "median relative difference of pixels at scale %g",
                  static_cast<double>(scale));
    Quantity& q = c.at_most(what, 1e-4);
    std::snprintf(what, sizeof what, "the same with photons at scale %g", static_cast<double>(scale));
    // Photons' fluxes are rounded at random to 1/256 by their bits: over some hundred photons 10⁻⁴ of the
    // estimate.
    Quantity& p = c.at_most(what, 5e-4);
    std::snprintf(what, sizeof what, "share of pixels that differ by 10⁻³ at scale %g",
                  static_cast<double>(scale));
    // A photon or path in the millions takes another way at a facet's edge; a pixel of final gather sees hundreds, and a
    // photon is seen by all pixels near it and near where it goes on to: six seeds differ from .005 to .084.
    Quantity& s = c.at_most(what, 0.2);
    for (const Method method : kMethods) {
      for (const std::uint64_t seed : kSeeds) {
        const Image one = picture(small_room(1), method, seed);
        const Image other = picture(small_room(scale), method, seed);
        (method == Method::path ? q : p).add(run_name(method, seed), median_difference(other, one));
        s.add(run_name(method, seed), strays(other, one));
      }
    }
  }
}

// Far from the origin floats are coarse (10⁵: 8 mm, 10⁷: 1 m), but the parts of this scene are placed by
// transforms that floats hold exactly, and prepare moves far scenes to the origin.
TEST(HardCase, Translation20) {
  HardCase c(20, "scene far from the origin, placed by transforms");
  for (const float distance : {1e5f, 1e7f}) {
    char what[64];
    std::snprintf(what, sizeof what, "median relative difference of pixels at %g m",
                  static_cast<double>(distance));
    Quantity& q = c.at_most(what, 0.01);
    for (const Method method : kMethods) {
      for (const std::uint64_t seed : kSeeds) {
        const Image here = picture(small_room(4), method, seed);
        const Image there = picture(small_room(4, Vec3(distance, -distance, 2 * distance)), method, seed);
        q.add(run_name(method, seed), median_difference(there, here));
      }
    }
  }
}

// Where the vertices themselves lie far away their file has rounded them: that cannot be undone, and is said.
TEST(HardCase, FarVertices20) {
  HardCase c(20, "scene far from the origin, placed by transforms");
  Quantity& q = c.equals("warnings of a triangle of 1 m whose vertices lie at 0, 10⁵ m, 10⁷ m", 2);
  double warned = 0;
  for (const float x : {0.0f, 1e5f, 1e7f}) {
    GlbDraft draft;
    const int positions = draft.add_accessor<float>({x, 0, 0, x + 1, 0, 0, x, 1, 0}, 5126, "VEC3", 3);
    draft.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = positions;
    const auto scene = read_gltf(draft.pack(), no_resources());
    ASSERT_TRUE(scene.ok());
    warned += std::any_of(scene->warnings.begin(), scene->warnings.end(), [](const std::string& w) {
      return w.find("far from the origin") != std::string::npos;
    });
  }
  q.add("", warned);
}

}  // namespace
}  // namespace photond
