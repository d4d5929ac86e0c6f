// Veach 1997: next-event estimation and multiple importance sampling.
#include "core/render/direct_light.h"

#include <cmath>
#include <iterator>

namespace photond {

namespace {

// A surface, and which of its lobes are lit.
struct Receiver {
  const PreparedScene& scene;
  const CameraPath& path;
  const SurfacePoint& surface;
  const Bsdf& bsdf;
  const Lobes& lobes;
  LobeMask followed;   // those of the followed lobes that sampled light can reach
};

// MIS weight of sampled light against finding it by going on through `mask` with probability `share`.
float weight(const Bsdf& bsdf, const DirectSample& light, LobeMask mask, float share) {
  if (share == 0 || light.pdf_w == 0) return 1;
  return power_heuristic(light.pdf_w, share * bsdf.pdf(light.wi, mask));
}

// Light from one sampled point, and the ray along which it comes; black where there is none.
struct Incoming {
  Ray ray;
  Rgb light{0};
};

// The volumes through which light comes from `wi`: those that the path would be in had it gone on that way.
Medium way_from(const Receiver& r, const Vec3& wi) {
  Medium medium = r.path.medium;
  medium.cross(r.scene.scene, r.surface, glm::dot(wi, r.surface.ng) < 0);
  return medium;
}

Incoming sample_light(const Receiver& r, const Vec3& u) {
  const DirectSample light = r.scene.lights.sample_direct(r.scene.scene, r.surface.position, u);
  if (is_black(light.radiance)) return {};
  Rgb f(0);
  if (r.lobes.gathered != kNoLobe) {
    f += weight(r.bsdf, light, r.lobes.gathered, r.lobes.gathered_share) *
         r.bsdf.eval(light.wi, r.lobes.gathered, Transport::radiance);
  }
  if (r.followed != kNoLobe) {
    f += weight(r.bsdf, light, r.lobes.followed, r.lobes.followed_share) *
         r.path.share(r.surface, light.wi, light.etendue) * r.bsdf.eval(light.wi, r.followed, Transport::radiance);
  }
  if (is_black(f)) return {};
  const Vec3 from = spawn_point(r.surface.position, r.surface.ng, r.surface.extent, light.wi);
  const Ray ray = light.infinite ? Ray{from, light.wi} : Ray{from, light.target - from, 1};
  Rgb contribution = r.path.throughput * f * light.radiance * std::abs(glm::dot(light.wi, r.surface.ns));
  const bool in_volumes = r.path.medium.active() || r.surface.material->transmission > 0;
  if (in_volumes && !light.infinite) {
    contribution *= way_from(r, light.wi).transmittance(r.scene.scene, glm::distance(from, light.target));
  }
  return {ray, contribution};
}

}  // namespace

void sample_direct_light(const PreparedScene& scene, const CameraPath& path, const SurfacePoint& surface,
                         const Bsdf& bsdf, const Lobes& lobes, CameraSampler& rng, std::uint32_t sample,
                         ShadowRays& shadows) {
  const LobeMask followed = path.gathering ? kNoLobe : lobes.followed & ~bsdf.delta_lobes();
  if ((lobes.gathered | followed) == kNoLobe || scene.lights.empty()) return;
  const Vec3 u(rng.next4());
  const Receiver receiver{scene, path, surface, bsdf, lobes, followed};
  const auto add = [&](const Vec3& v, float share) {
    const Incoming incoming = sample_light(receiver, v);
    if (!is_black(incoming.light)) shadows.add(sample, incoming.ray, share * incoming.light);
  };
  const bool ends = lobes.gathered != kNoLobe && lobes.gathered_share == 0;
  if (!ends || path.gathering) return add(u, 1);
  // A path that ends in photons has cost much and sees light once: several points of the lights, evenly spread.
  static constexpr Vec3 kShifts[] = {{0, 0, 0}, {0.5f, 0.5f, 0.25f}, {0.25f, 0.75f, 0.5f}, {0.75f, 0.25f, 0.75f}};
  for (const Vec3& shift : kShifts) add(shifted(u, shift), 1.0f / std::size(kShifts));
}

}  // namespace photond
