#include "core/render/pilot.h"

#include <algorithm>
#include <cmath>

#include "core/photon/estimate.h"
#include "core/photon/shoot.h"

namespace photond {

namespace {

constexpr std::uint32_t kPilotPass = 0xffffffff;     // a pass number no rendering reaches
constexpr std::uint32_t kPilotPhotons = 32'768;      // a few percent of a pass
constexpr std::uint32_t kNeighbours = 16;
constexpr int kQueriesPerSide = 32;
constexpr int kMaxSpecular = 16;
// Photons of one pass inside the first radius. Few: too wide a radius costs far more time than too narrow a one.
constexpr float kPhotonsInRadius = 12;
constexpr float kMinFootprints = 0.75f;
constexpr float kMaxFootprints = 6;

// Density of the map at a point, photons per m².
float density(const PhotonMap& map, const Vec3& point, float max_radius_sq) {
  if (map.size() < kNeighbours) return 0;
  const float r_sq = nearest_radius_sq(map, point, kNeighbours, max_radius_sq);
  return r_sq > 0 && r_sq < max_radius_sq ? static_cast<float>(kNeighbours - 1) / (kPi * r_sq) : 0;
}

// The radius wished for where the ray first meets a surface that gathers; 0 where it does not.
float wished_radius(const PreparedScene& scene, const PhotonMaps& maps, Ray ray, Rng rng, float spread, float growth) {
  float distance = 0;
  for (int bounce = 0; bounce < kMaxSpecular; ++bounce) {
    const Hit hit = scene.accel.intersect(ray);
    if (!hit.found()) return 0;
    distance += hit.t;
    const SurfacePoint surface = make_surface(scene.scene, ray, hit);
    const Bsdf bsdf(scene.scene, surface, -ray.direction);
    if (gathered_lobes(bsdf) != kNoLobe) {
      const float max_radius_sq = scene.bounds.radius() * scene.bounds.radius();
      const float found = density(maps.global, surface.position, max_radius_sq) +
                          density(maps.caustic, surface.position, max_radius_sq);
      const float footprint = distance * spread;
      const float wished = found > 0 ? std::sqrt(kPhotonsInRadius / (kPi * found * growth)) : kInfinity;
      return std::clamp(wished, kMinFootprints * footprint, kMaxFootprints * footprint);
    }
    const Vec2 u = rng.next2();
    const auto sample = bsdf.sample({u, rng.next()}, kAllLobes, Transport::radiance);
    if (!sample) return 0;
    ray = spawn_ray(surface, sample->wi);
  }
  return 0;
}

}  // namespace

Result<float> pilot_radius(const PreparedScene& scene, const Camera& camera, const PhotonSettings& photons,
                           const RenderSettings& settings, const Execution& execution) {
  PhotonSettings pilot = photons;
  pilot.photons_per_pass = std::min(photons.photons_per_pass, kPilotPhotons);
  const auto maps = build_photon_maps(scene, {scene.digest, pilot, kPilotPass}, execution);
  if (!maps) return maps.error();

  const float growth = static_cast<float>(photons.photons_per_pass) / static_cast<float>(pilot.photons_per_pass);
  const float aspect = static_cast<float>(settings.width) / static_cast<float>(settings.height);
  // Of an orthographic camera the spread is a width already; its distance is taken as one.
  const float spread = pixel_spread(camera, settings.height);
  std::vector<float> radii(kQueriesPerSide * kQueriesPerSide);
  parallel_for(execution, radii.size(), 16, [&](std::size_t i) {
    const auto x = static_cast<float>(i % kQueriesPerSide);
    const auto y = static_cast<float>(i / kQueriesPerSide);
    const Vec2 film{(x + 0.5f) / kQueriesPerSide, (y + 0.5f) / kQueriesPerSide};
    const Rng rng(settings.seed, RngPurpose::pilot, 0, i);
    radii[i] = wished_radius(scene, **maps, camera_ray(camera, film, aspect), rng, spread, growth);
  });
  if (execution.cancelled()) return cancelled();
  std::erase(radii, 0.0f);
  if (radii.empty()) return 0.01f * std::max(scene.bounds.radius(), std::numeric_limits<float>::min());
  std::nth_element(radii.begin(), radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2), radii.end());
  return radii[radii.size() / 2];
}

}  // namespace photond
