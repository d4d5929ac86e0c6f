// The density estimate on photons laid by hand, where its expectation is known.
#include "core/photon/nearest.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "core/math/warp.h"
#include "tests/render/look.h"
#include "tests/support/estimate.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

using namespace test;

constexpr double kPiD = std::numbers::pi;

// A white surface to estimate on. Radiance by unit photons is their density over π.
struct Receiver {
  std::shared_ptr<const PreparedScene> scene;

  explicit Receiver(Mesh mesh) {
    Scene s = empty_scene();
    add_mesh(s, std::move(mesh), add_material(s, lambert(Rgb(1))));
    scene = prepared(std::move(s));
  }
  // The density of unit photons where `ray` meets the surface.
  double density(const PhotonMap& map, const Ray& ray, double radius) const {
    const SurfacePoint s = make_surface(scene->scene, ray, scene->accel.intersect(ray));
    const Bsdf bsdf(scene->scene, s, -ray.direction);
    return kPiD *
           static_cast<double>(
               test::estimate_radiance(map, s, bsdf, kDiffuseLobe, static_cast<float>(radius * radius)).x);
  }
};

// `count` unit photons uniform on the rectangle [0,w]×[0,h] of z = 0, from above.
void add_floor(std::vector<Photon>& photons, Rng& rng, int count, float w = 1, float h = 1) {
  for (int i = 0; i < count; ++i) {
    const Vec2 u = rng.next2();
    photons.push_back({{w * u.x, h * u.y, 0}, encode_direction({0, 0, 1}), encode_normal({0, 0, 1}), nearest_flux(Rgb(1))});
  }
}

// Mean over `maps` random maps of `measure`.
template <class Lay, class Measure>
Sample over_maps(std::uint64_t seed, int maps, const Lay& lay, const Measure& measure) {
  Sample sample;
  for (int i = 0; i < maps; ++i) {
    Rng rng(seed, RngPurpose::pilot, 29, static_cast<std::uint64_t>(i));
    std::vector<Photon> photons;
    lay(photons, rng);
    sample.add(measure(PhotonMap(photons, Execution{})));
  }
  return sample;
}

// The k − 1 photons nearer than the k-th are uniform in its disc, whose area A has E[1/A] = λ/(k − 1): an
// estimate by them has the mean λ, one that counts the k-th too λk/(k − 1) [García et al. 2012].
TEST(HardCase, NearestPhotons29) {
  HardCase c(29, "k nearest on uniform density, k = 10");
  constexpr std::uint32_t kNearest = 10;
  Quantity& used = c.equals("estimate over density", 1);
  Quantity& textbook = c.equals("(k − 1)/(πr²) over density", 1);
  Quantity& wrong = c.equals("with the k-th photon, k/(πr²): k/(k − 1)", 10.0 / 9);
  const Receiver floor(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  for (const std::uint64_t seed : kSeeds) {
    Sample kernel, without, with;
    over_maps(
        seed, 4000, [](auto& photons, Rng& rng) { add_floor(photons, rng, 1000); },
        [&](const PhotonMap& map) {
          const float r_sq = nearest_radius_sq(map, {0.5f, 0.5f, 0}, kNearest, 1);
          const double area = kPiD * static_cast<double>(r_sq);
          kernel.add(floor.density(map, {{0.5f, 0.5f, 1}, {0, 0, -1}}, std::sqrt(static_cast<double>(r_sq))) /
                     1000);
          without.add((kNearest - 1) / area / 1000);
          with.add(kNearest / area / 1000);
          return 0.0;
        });
    used.add("seed " + std::to_string(seed), kernel);
    textbook.add("seed " + std::to_string(seed), without);
    wrong.add("seed " + std::to_string(seed), with);
    EXPECT_FALSE(agrees(with, 1)) << "the textbook's mistake must be seen";
  }
}

// The disc at an edge lies half beside the plate, at a corner three quarters: there is no correction, the
// estimate falls short, in a strip that narrows with the radius.
TEST(HardCase, Boundary30) {
  HardCase c(30, "density at the boundary of a plate, without correction");
  const Receiver floor(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  struct Place {
    const char* what;
    Vec2 at;
    double radius, share;
  };
  // Half a radius inside, the share is the distribution function at ½ of the kernel's marginal
  // f(x) = 8/(3π)(1 − x²)^{3/2}, here by quadrature.
  double cdf = 0.5;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i) {
    const double x = 0.5 * (i + 0.5) / kSteps;
    cdf += 8 / (3 * kPiD) * std::pow(1 - x * x, 1.5) * 0.5 / kSteps;
  }
  // One ten-millionth off the border, where a ray still meets the plate.
  const Place places[] = {{"at an edge: 1/2", {1e-7f, 0.5f}, 0.1, 0.5},
                          {"at a corner: 1/4", {1e-7f, 1e-7f}, 0.1, 0.25},
                          {"half a radius inside", {0.05f, 0.5f}, 0.1, cdf},
                          {"at that place with half the radius: 1", {0.05f, 0.5f}, 0.05, 1}};
  for (const Place& place : places) {
    Quantity& q = c.equals(place.what, place.share);
    for (const std::uint64_t seed : kSeeds) {
      q.add("seed " + std::to_string(seed),
            over_maps(
                seed, 400, [](auto& photons, Rng& rng) { add_floor(photons, rng, 10'000); },
                [&](const PhotonMap& map) {
                  return floor.density(map, {{place.at.x, place.at.y, 1}, {0, 0, -1}}, place.radius) / 10'000;
                }));
    }
  }
}

// A ball of radius r around a point of a sphere cuts off a cap of area πr² exactly, for every r: no radial
// kernel has a bias by a sphere's curvature. Beyond r = Rs photons turned by more than 60° are left out as
// another surface's.
TEST(HardCase, SphereReceiver31) {
  HardCase c(31, "density on a sphere: a ball cuts a cap of πr²");
  const Receiver ball(sphere({0, 0, 0}, 1, 128));
  for (const double radius : {0.2, 0.5, 0.95}) {
    char what[32];
    std::snprintf(what, sizeof what, "estimate at r = %g Rs", radius);
    // The query point lies on a facet, up to (π/128)²/8 inside the sphere of the photons: negligible.
    Quantity& q = c.equals(what, 1, {.relative = 1e-4});
    for (const std::uint64_t seed : kSeeds) {
      const auto lay = [](std::vector<Photon>& photons, Rng& rng) {
        for (int i = 0; i < 5000; ++i) {
          const Vec3 n = square_to_sphere(rng.next2());
          photons.push_back({n, encode_direction(n), encode_normal(n), nearest_flux(Rgb(1))});
        }
      };
      q.add("seed " + std::to_string(seed), over_maps(seed, 600, lay, [&](const PhotonMap& map) {
              // Photons come along their own normals here; on smooth normals the estimate divides by their
              // cosine at the query and multiplies by the shaded one, which differ by facets only.
              return ball.density(map, {{0, 0, 3}, {0, 0, -1}}, radius) * 4 * kPiD / 5000;
            }));
    }
  }
}

// The kernel's reach over a line: ∫ P(X > t) dt = E[X⁺] = 8r/(15π), for the Epanechnikov disc (E|d| = 8r/15,
// times the mean of cos⁺, 1/π).
double reach(double radius) { return 8 * radius / (15 * kPiD); }

// Mean of density/λ over the strip [from, to] beside the line x = 1 of a floor lit for x < 1, seen from above.
double strip(const Receiver& floor, const PhotonMap& map, double lambda, double from, double to,
             double radius) {
  constexpr int kSteps = 20;  // the midpoint rule errs by .05 %
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double x = from + (to - from) * (i + 0.5) / kSteps;
    sum += floor.density(map, {{static_cast<float>(x), 0.5f, 1}, {0, 0, -1}}, radius) / lambda;
  }
  return sum * (to - from) / kSteps;
}

// A wall thinner than the radius between a lit and a dark room. The wall's dark side shows nothing of the
// photons on its lit side. The floor has one normal on both sides: light leaks under the wall, in all
// λ·8r/(15π) a metre of it.
TEST(HardCase, ThinWall32) {
  HardCase c(32, "wall thinner than the radius between a lit and a dark room");
  Mesh rooms = parallelogram({0, 0, 0}, {2, 0, 0}, {0, 1, 0});
  const Receiver floor(rooms);
  const Receiver wall(parallelogram({1.001f, 0, 0}, {0, 1, 0}, {0, 0, 1}));  // its dark side looks towards +x
  Quantity& dark = c.equals("density on the wall's dark side", 0);
  for (const double radius : {0.2, 0.1, 0.05}) {
    char what[48];
    std::snprintf(what, sizeof what, "leak on the floor over r, at r = %g", radius);
    Quantity& q = c.equals(what, reach(1), {.relative = 5e-4, .precision = 0.02});
    for (const std::uint64_t seed : kSeeds) {
      const auto lay = [](std::vector<Photon>& photons, Rng& rng) {
        add_floor(photons, rng, 10'000);
        for (int i = 0; i < 10'000; ++i) {  // the wall's lit side, at x = 1
          const Vec2 u = rng.next2();
          photons.push_back({{1, u.x, u.y}, encode_direction({-1, 0, 0}), encode_normal({-1, 0, 0}), nearest_flux(Rgb(1))});
        }
      };
      q.add("seed " + std::to_string(seed), over_maps(seed, 200, lay, [&](const PhotonMap& map) {
              return strip(floor, map, 10'000, 1, 1 + radius, radius) / radius;
            }));
      Rng rng(seed, RngPurpose::pilot, 32, 0);
      std::vector<Photon> photons;
      lay(photons, rng);
      dark.add("seed " + std::to_string(seed),
               wall.density(PhotonMap(photons, Execution{}), {{2, 0.5f, 0.5f}, {-1, 0, 0}}, radius));
    }
  }
}

// In a crease of 90° the disc reaches over the line, and the wall's photons are not counted: what is missing is
// λ·8r/(15π) a metre, a darkening as wide as r.
TEST(HardCaseStatistical, Crease33) {
  HardCase c(33, "crease of 90°");
  const Receiver floor(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  for (const double radius : {0.2, 0.1, 0.05}) {
    char what[48];
    std::snprintf(what, sizeof what, "missing light over r, at r = %g", radius);
    Quantity& q = c.equals(what, reach(1), {.relative = 5e-4, .precision = 0.06});
    for (const std::uint64_t seed : kSeeds) {
      const auto lay = [](std::vector<Photon>& photons, Rng& rng) {
        add_floor(photons, rng, 10'000);
        for (int i = 0; i < 10'000; ++i) {
          const Vec2 u = rng.next2();
          photons.push_back({{1, u.x, u.y}, encode_direction({-1, 0, 0}), encode_normal({-1, 0, 0}), nearest_flux(Rgb(1))});
        }
      };
      q.add("seed " + std::to_string(seed), over_maps(seed, 200, lay, [&](const PhotonMap& map) {
              return 1 - strip(floor, map, 10'000, 1 - radius, 1, radius) / radius;
            }));
    }
  }
}

// Photons in clusters, in planes and in one place: an indexed gather finds each photon of the ball once. (Where
// cells are hashed, two cells of one bucket are visited twice.)
TEST(HardCase, IndexedGather40) {
  HardCase c(40, "indexed gather against brute force");
  std::vector<Vec3> points;
  Rng rng(40, RngPurpose::pilot, 40, 0);
  for (int i = 0; i < 30'000; ++i) {
    const float x = rng.next(), y = rng.next(), z = rng.next();
    if (i % 3 == 0) points.push_back({x, y, z});
    if (i % 3 == 1) points.push_back({x * x * x * x, 0.25f, z * z});
    if (i % 3 == 2) points.push_back({0.5f, std::floor(4 * y) / 4, 0.5f});
  }
  std::vector<Photon> photons;
  for (const Vec3& p : points) photons.push_back({p, 0, 0, nearest_flux(Rgb(1))});
  const PhotonMap map(photons, workers().execution());
  const auto key = [](const Vec3& p) { return std::array<float, 3>{p.x, p.y, p.z}; };
  int mismatches = 0;
  for (int q = 0; q < 300; ++q) {
    const Vec3 center =
        q % 2 == 0 ? points[rng.next_uint() % points.size()] : Vec3(rng.next(), rng.next(), rng.next());
    const float r_sq = 0.1f * rng.next() * rng.next();
    std::multiset<std::array<float, 3>> found, expected;
    map.tree().query(center, r_sq, [&](std::span<const std::uint32_t> leaves) {
      for (const std::uint32_t leaf : leaves) {
        const auto d_sq = map.leaf(leaf).distances_sq(center);
        for (std::uint32_t i = 0; i < PhotonLeaf::kSize; ++i) {
          if (d_sq[i] < r_sq) found.insert(key(map.position(leaf * PhotonLeaf::kSize + i)));
        }
      }
    });
    for (const Vec3& p : points) {
      // Within a rounding of the border a photon may count or not.
      const float d_sq = glm::dot(p - center, p - center);
      if (std::abs(d_sq - r_sq) <= 1e-6f * r_sq) {
        found.erase(key(p));
      } else if (d_sq < r_sq) {
        expected.insert(key(p));
      }
    }
    mismatches += found != expected;
  }
  c.equals("queries that differ, of 300", 0).add("", mismatches);
}

}  // namespace
}  // namespace photond
