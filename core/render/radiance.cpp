// Veach 1997: next-event estimation and multiple importance sampling. Jensen 1996: photon map rendering.
#include "core/render/radiance.h"

#include <array>
#include <cmath>

#include "core/photon/estimate.h"
#include "core/photon/scales.h"
#include "core/photon/shoot.h"
#include "core/trace/medium.h"
#include "core/trace/roulette.h"

namespace photond {

namespace {

// Bounces before roulette starts on camera paths, whose first vertices carry most of the picture.
constexpr std::uint32_t kRouletteDepth = 4;

float power_heuristic(float pdf, float other) {
  const float a = pdf * pdf;
  const float b = other * other;
  return a > 0 ? a / (a + b) : 0;
}

// Vertices from the camera on at which smooth glass is followed both ways: a bright reflection on water is seen in
// every pass instead of in one of fifty.
constexpr std::uint32_t kSplitDepth = 2;

// Where a path stands, and what it carries.
struct PathState {
  Ray ray;
  Rgb throughput{1};
  float compression = 1;         // of radiance by the refractions so far
  float distance = 0;            // travelled since the camera
  Medium medium;
  std::uint32_t depth = 0;
  bool last_delta = true;
  float last_pdf = 0;
  Vec3 last_position{0};
};

// One walk from the camera (or from a gather point) through the scene.
class RadianceWalk {
 public:
  // `see_emitters`: emission met, and light sampled for followed lobes, belongs to this walk. A final-gather ray
  // leaves both to its origin's direct light and caustics.
  RadianceWalk(const PreparedScene& scene, const RadianceSettings& settings, CameraSampler& rng, bool see_emitters)
      : scene_(scene), settings_(settings), rng_(rng), see_emitters_(see_emitters) {}

  RadianceSample run(const Ray& ray) {
    path_.ray = ray;
    for (;;) {
      while (step()) ++path_.depth;
      if (waiting_ == 0) break;
      path_ = branches_[--waiting_];
    }
    return {radiance_ + gathered_.widest, gathered_.bands, truncated_};
  }

 private:
  bool step() {
    const Hit hit = scene_.accel.intersect(path_.ray);
    if (!hit.found()) {
      add_environment();
      return false;
    }
    const SurfacePoint surface = make_surface(scene_.scene, path_.ray, hit);
    path_.throughput *= path_.medium.transmittance(surface, hit.t);
    add_emission(surface);
    // The last bounce's light may be found here as well as by sampling it from there: only now the path is cut.
    if (path_.depth == settings_.max_depth) {
      truncated_ = true;
      return false;
    }
    const Bsdf bsdf(scene_.scene, surface, -path_.ray.direction);
    const LobeMask gathered = settings_.technique == Technique::trace ? kNoLobe : gathered_lobes(bsdf);
    const LobeMask followed = bsdf.lobes() & ~gathered;
    add_direct(surface, bsdf, gathered, followed);
    path_.distance += hit.t;
    if (gathered != kNoLobe) add_indirect(surface, bsdf, gathered);
    return followed != kNoLobe && follow(surface, bsdf, followed);
  }

  // MIS weight of light found by following a lobe, against sampling it from the previous vertex.
  float hit_weight(float pdf_direct) const {
    return path_.depth == 0 || path_.last_delta ? 1 : power_heuristic(path_.last_pdf, pdf_direct);
  }

  void add_environment() {
    if (!see_emitters_ || !scene_.scene.environment.active()) return;
    radiance_ += path_.throughput * scene_.scene.environment.radiance * hit_weight(scene_.lights.pdf_environment());
  }

  void add_emission(const SurfacePoint& surface) {
    if (!see_emitters_ || !surface.material->emissive()) return;
    const Rgb emitted = emitted_radiance(scene_.scene, surface);
    if (is_black(emitted)) return;
    const bool sampled = path_.depth > 0 && !path_.last_delta;
    const float pdf_direct = sampled ? scene_.lights.pdf_direct(path_.last_position, surface) : 0;
    radiance_ += path_.throughput * emitted * hit_weight(pdf_direct);
  }

  // Next-event estimation: alone for the gathered lobes, weighted against following for the others.
  void add_direct(const SurfacePoint& surface, const Bsdf& bsdf, LobeMask gathered, LobeMask followed) {
    const LobeMask weighted = see_emitters_ ? followed & ~bsdf.delta_lobes() : kNoLobe;
    if ((gathered | weighted) == kNoLobe || scene_.lights.empty()) return;
    const Vec3 u(rng_.next4());
    if (gathered == kNoLobe || settings_.technique == Technique::trace || !see_emitters_) {
      radiance_ += path_.throughput * direct(surface, bsdf, gathered, weighted, followed, u);
      return;
    }
    // A path that ends in photons has cost much and sees light once: several points of the lights, evenly spread.
    static constexpr Vec3 kShifts[] = {{0, 0, 0}, {0.5f, 0.5f, 0.25f}, {0.25f, 0.75f, 0.5f}, {0.75f, 0.25f, 0.75f}};
    Rgb sum(0);
    for (const Vec3& shift : kShifts) {
      sum += direct(surface, bsdf, gathered, weighted, followed, glm::fract(u + shift));
    }
    radiance_ += path_.throughput * (sum / static_cast<float>(std::size(kShifts)));
  }

  Rgb direct(const SurfacePoint& surface, const Bsdf& bsdf, LobeMask gathered, LobeMask weighted, LobeMask followed,
             const Vec3& u) const {
    const DirectSample light = scene_.lights.sample_direct(scene_.scene, surface.position, u);
    if (is_black(light.radiance)) return Rgb(0);
    Rgb f(0);
    if (gathered != kNoLobe) f += bsdf.eval(light.wi, gathered, Transport::radiance);
    if (weighted != kNoLobe) {
      const float weight = light.pdf_w > 0 ? power_heuristic(light.pdf_w, bsdf.pdf(light.wi, followed)) : 1;
      f += weight * bsdf.eval(light.wi, weighted, Transport::radiance);
    }
    if (is_black(f)) return Rgb(0);
    const Vec3 from = spawn_point(surface.position, surface.ng, surface.extent, light.wi);
    const bool hidden = light.infinite ? scene_.accel.occluded(Ray{from, light.wi})
                                       : scene_.accel.occluded(from, light.target);
    if (hidden) return Rgb(0);
    Rgb contribution = f * light.radiance * std::abs(glm::dot(light.wi, surface.ns));
    if (path_.medium.active() && !light.infinite) {
      contribution *= path_.medium.transmittance(glm::distance(from, light.target));
    }
    return contribution;
  }

  void add_indirect(const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask) {
    const PhotonMaps& maps = *settings_.maps;
    switch (settings_.technique) {
      case Technique::trace:
        break;
      case Technique::density:
        add_density(surface, bsdf, mask);
        break;
      case Technique::nearest:
        radiance_ += path_.throughput * (estimate(maps.global, surface, bsdf, mask) +
                                    estimate(maps.caustic, surface, bsdf, mask));
        break;
      case Technique::final_gather:
        radiance_ += path_.throughput * (estimate(maps.caustic, surface, bsdf, mask) + gather(surface, bsdf, mask));
        break;
    }
  }

  void add_density(const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask) {
    const Rgb scale = path_.throughput / static_cast<float>(settings_.maps->emitted);
    const auto add = [&](const PhotonMap& map, const Bandwidth& bandwidth) {
      if (map.size() == 0) return;
      const float radius_sq = settings_.radius_sq > 0 ? settings_.radius_sq : widest_radius_sq(surface, bandwidth);
      if (!(radius_sq > 0)) return;
      const Reach reach(guide().edges, surface.position, surface.ng, std::sqrt(radius_sq));
      estimate_scales(map, surface, bsdf, mask, reach, radius_sq, scale, gathered_);
    };
    add(settings_.maps->global, guide().global);
    add(settings_.maps->caustic, guide().caustic);
  }

  const GatherGuide& guide() const {
    static const GatherGuide kNone;
    return settings_.guide != nullptr ? *settings_.guide : kNone;
  }

  // Enough photons for little noise within a pass, but no wider than the narrowest scale resolves pixels.
  float widest_radius_sq(const SurfacePoint& surface, const Bandwidth& bandwidth) const {
    static constexpr float kPhotons = 150;
    static constexpr float kFootprints = 24;
    const float widest = kFootprints * (settings_.pixel_width + settings_.pixel_spread * path_.distance);
    const float dense = bandwidth.radius_sq(surface.position, kPhotons);
    return settings_.shrink * (dense > 0 ? std::min(dense, widest * widest) : widest * widest);
  }

  Rgb estimate(const PhotonMap& map, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask) const {
    if (map.size() == 0) return Rgb(0);
    const float radius_sq = nearest_radius_sq(map, surface.position, settings_.nearest, settings_.radius_sq);
    if (!(radius_sq > 0)) return Rgb(0);
    const Reach reach(guide().edges, surface.position, surface.ng, std::sqrt(radius_sq));
    ScaleEstimate sum;
    estimate_scales(map, surface, bsdf, mask, reach, radius_sq, Rgb(1), sum);
    return sum.widest / static_cast<float>(settings_.maps->emitted);
  }

  Rgb gather(const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask) {
    const auto sample = bsdf.sample(Vec3(rng_.next4()), mask, Transport::radiance);
    if (!sample) return Rgb(0);
    RadianceSettings settings = settings_;
    settings.technique = Technique::nearest;
    RadianceWalk walk(scene_, settings, rng_, false);
    const RadianceSample incoming = walk.run(spawn_ray(surface, sample->wi));
    truncated_ = truncated_ || incoming.truncated;
    return sample->weight * incoming.radiance;
  }

  bool follow(const SurfacePoint& surface, const Bsdf& bsdf, LobeMask lobes) {
    if (path_.depth < kSplitDepth && settings_.technique != Technique::trace) {
      const float reflected = bsdf.smooth_glass_reflectance();
      if (reflected > 0 && reflected < 1) return follow_both(surface, bsdf, reflected);
    }
    const Vec4 u = rng_.next4();
    const auto sample = bsdf.sample(Vec3(u), lobes, Transport::radiance);
    if (!sample) return false;
    continue_by(surface, *sample, 1);
    // Roulette by the weight without refraction's compression, which a later refraction undoes.
    if (path_.depth >= kRouletteDepth) {
      const float survival =
          survival_probability(max_component(path_.throughput) * path_.compression, path_.depth);
      if (!(u.w < survival)) return false;
      path_.throughput /= survival;
    }
    return true;
  }

  // Goes on by refraction and keeps the reflection for later, each with its share instead of by chance.
  bool follow_both(const SurfacePoint& surface, const Bsdf& bsdf, float reflected) {
    const auto reflection = bsdf.sample({0, 0, 0}, kGlassLobe, Transport::radiance);
    const auto refraction = bsdf.sample({0, 0, 0x1.fffffep-1f}, kGlassLobe, Transport::radiance);
    const PathState before = path_;
    if (reflection) {
      continue_by(surface, *reflection, reflected);
      ++path_.depth;
      branches_[waiting_++] = path_;
    }
    if (!refraction) return false;
    path_ = before;
    continue_by(surface, *refraction, 1 - reflected);
    return true;
  }

  void continue_by(const SurfacePoint& surface, const BsdfSample& sample, float share) {
    path_.throughput *= sample.weight * share;
    if (sample.transmitted) path_.compression *= compression(*surface.material, surface.front);
    path_.medium.cross(surface, sample);
    path_.last_delta = sample.delta;
    path_.last_pdf = sample.pdf_w;
    path_.last_position = surface.position;
    path_.ray = spawn_ray(surface, sample.wi);
  }

  static float compression(const Material& material, bool front) {
    if (material.thin_walled || material.ior == 0) return 1;
    const float eta_sq = material.ior * material.ior;
    return front ? eta_sq : 1 / eta_sq;
  }

  const PreparedScene& scene_;
  const RadianceSettings& settings_;
  CameraSampler& rng_;
  bool see_emitters_;
  PathState path_;
  std::array<PathState, kSplitDepth> branches_;   // waiting to be followed: one for each vertex that has split
  std::uint32_t waiting_ = 0;
  Rgb radiance_{0};
  ScaleEstimate gathered_;
  bool truncated_ = false;
};

}  // namespace

RadianceSample estimate_incoming(const PreparedScene& scene, const RadianceSettings& settings, const Ray& ray,
                                 CameraSampler& sampler) {
  return RadianceWalk(scene, settings, sampler, true).run(ray);
}

}  // namespace photond
