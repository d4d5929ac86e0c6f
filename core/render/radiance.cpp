// Veach 1997: next-event estimation and multiple importance sampling. Jensen 1996: photon map rendering.
#include "core/render/radiance.h"

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

// One walk from the camera (or from a gather point) through the scene.
class RadianceWalk {
 public:
  // `see_emitters`: emission met, and light sampled for followed lobes, belongs to this walk. A final-gather ray
  // leaves both to its origin's direct light and caustics.
  RadianceWalk(const PreparedScene& scene, const RadianceSettings& settings, CameraSampler& rng, bool see_emitters)
      : scene_(scene), settings_(settings), rng_(rng), see_emitters_(see_emitters) {}

  RadianceSample run(const Ray& ray) {
    ray_ = ray;
    for (depth_ = 0; step(); ++depth_) {
    }
    return {radiance_ + gathered_.widest, gathered_.bands, truncated_};
  }

 private:
  bool step() {
    const Hit hit = scene_.accel.intersect(ray_);
    if (!hit.found()) {
      add_environment();
      return false;
    }
    const SurfacePoint surface = make_surface(scene_.scene, ray_, hit);
    throughput_ *= medium_.transmittance(surface, hit.t);
    add_emission(surface);
    // The last bounce's light may be found here as well as by sampling it from there: only now the path is cut.
    if (depth_ == settings_.max_depth) {
      truncated_ = true;
      return false;
    }
    const Bsdf bsdf(scene_.scene, surface, -ray_.direction);
    const LobeMask gathered = settings_.technique == Technique::trace ? kNoLobe : gathered_lobes(bsdf);
    const LobeMask followed = bsdf.lobes() & ~gathered;
    add_direct(surface, bsdf, gathered, followed);
    distance_ += hit.t;
    if (gathered != kNoLobe) add_indirect(surface, bsdf, gathered);
    return followed != kNoLobe && follow(surface, bsdf, followed);
  }

  // MIS weight of light found by following a lobe, against sampling it from the previous vertex.
  float hit_weight(float pdf_direct) const {
    return depth_ == 0 || last_delta_ ? 1 : power_heuristic(last_pdf_, pdf_direct);
  }

  void add_environment() {
    if (!see_emitters_ || !scene_.scene.environment.active()) return;
    radiance_ += throughput_ * scene_.scene.environment.radiance * hit_weight(scene_.lights.pdf_environment());
  }

  void add_emission(const SurfacePoint& surface) {
    if (!see_emitters_ || !surface.material->emissive()) return;
    const Rgb emitted = emitted_radiance(scene_.scene, surface);
    if (is_black(emitted)) return;
    const bool sampled = depth_ > 0 && !last_delta_;
    const float pdf_direct = sampled ? scene_.lights.pdf_direct(last_position_, surface) : 0;
    radiance_ += throughput_ * emitted * hit_weight(pdf_direct);
  }

  // Next-event estimation: alone for the gathered lobes, weighted against following for the others.
  void add_direct(const SurfacePoint& surface, const Bsdf& bsdf, LobeMask gathered, LobeMask followed) {
    const LobeMask weighted = see_emitters_ ? followed & ~bsdf.delta_lobes() : kNoLobe;
    if ((gathered | weighted) == kNoLobe || scene_.lights.empty()) return;
    const Vec2 u = rng_.next2();
    const float choice = rng_.next();
    const DirectSample light = scene_.lights.sample_direct(scene_.scene, surface.position, {u, choice});
    if (is_black(light.radiance)) return;
    Rgb f(0);
    if (gathered != kNoLobe) f += bsdf.eval(light.wi, gathered, Transport::radiance);
    if (weighted != kNoLobe) {
      const float weight = light.pdf_w > 0 ? power_heuristic(light.pdf_w, bsdf.pdf(light.wi, followed)) : 1;
      f += weight * bsdf.eval(light.wi, weighted, Transport::radiance);
    }
    if (is_black(f)) return;
    const Vec3 from = spawn_point(surface.position, surface.ng, surface.extent, light.wi);
    const bool hidden = light.infinite ? scene_.accel.occluded(Ray{from, light.wi})
                                       : scene_.accel.occluded(from, light.target);
    if (hidden) return;
    Rgb contribution = f * light.radiance * std::abs(glm::dot(light.wi, surface.ns));
    if (medium_.active() && !light.infinite) {
      contribution *= medium_.transmittance(glm::distance(from, light.target));
    }
    radiance_ += throughput_ * contribution;
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
        radiance_ += throughput_ * (estimate(maps.global, surface, bsdf, mask) +
                                    estimate(maps.caustic, surface, bsdf, mask));
        break;
      case Technique::final_gather:
        radiance_ += throughput_ * (estimate(maps.caustic, surface, bsdf, mask) + gather(surface, bsdf, mask));
        break;
    }
  }

  void add_density(const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask) {
    static const GatherGuide kNoGuide;
    const GatherGuide& guide = settings_.guide != nullptr ? *settings_.guide : kNoGuide;
    const Rgb scale = throughput_ / static_cast<float>(settings_.maps->emitted);
    const auto add = [&](const PhotonMap& map, const Bandwidth& bandwidth) {
      if (map.size() == 0) return;
      const float radius_sq = settings_.radius_sq > 0 ? settings_.radius_sq : widest_radius_sq(surface, bandwidth);
      if (!(radius_sq > 0)) return;
      const Reach reach(guide.edges, surface.position, surface.ng, std::sqrt(radius_sq));
      estimate_scales(map, surface, bsdf, mask, reach, radius_sq, scale, gathered_);
    };
    add(settings_.maps->global, guide.global);
    add(settings_.maps->caustic, guide.caustic);
  }

  // Enough photons for little noise within a pass, but no wider than the narrowest scale resolves pixels.
  float widest_radius_sq(const SurfacePoint& surface, const Bandwidth& bandwidth) const {
    static constexpr float kPhotons = 150;
    static constexpr float kFootprints = 24;
    const float widest = kFootprints * (settings_.pixel_width + settings_.pixel_spread * distance_);
    const float dense = bandwidth.radius_sq(surface.position, kPhotons);
    return settings_.shrink * (dense > 0 ? std::min(dense, widest * widest) : widest * widest);
  }

  Rgb estimate(const PhotonMap& map, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask) const {
    if (map.size() == 0) return Rgb(0);
    const float radius_sq = nearest_radius_sq(map, surface.position, settings_.nearest, settings_.radius_sq);
    if (!(radius_sq > 0)) return Rgb(0);
    return estimate_radiance(map, surface, bsdf, mask, radius_sq).radiance /
           static_cast<float>(settings_.maps->emitted);
  }

  Rgb gather(const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask) {
    const Vec2 u = rng_.next2();
    const float choice = rng_.next();
    const auto sample = bsdf.sample({u, choice}, mask, Transport::radiance);
    if (!sample) return Rgb(0);
    RadianceSettings settings = settings_;
    settings.technique = Technique::nearest;
    RadianceWalk walk(scene_, settings, rng_, false);
    const RadianceSample incoming = walk.run(spawn_ray(surface, sample->wi));
    truncated_ = truncated_ || incoming.truncated;
    return sample->weight * incoming.radiance;
  }

  bool follow(const SurfacePoint& surface, const Bsdf& bsdf, LobeMask lobes) {
    const Vec2 u = rng_.next2();
    const float choice = rng_.next();
    const auto sample = bsdf.sample({u, choice}, lobes, Transport::radiance);
    if (!sample) return false;
    throughput_ *= sample->weight;
    // Roulette by the weight without refraction's compression, which a later refraction undoes.
    if (sample->transmitted) compression_ *= compression(*surface.material, surface.front);
    if (depth_ >= kRouletteDepth) {
      const float survival = survival_probability(max_component(throughput_) * compression_, depth_);
      if (!(rng_.next() < survival)) return false;
      throughput_ /= survival;
    }
    medium_.cross(surface, *sample);
    last_delta_ = sample->delta;
    last_pdf_ = sample->pdf_w;
    last_position_ = surface.position;
    ray_ = spawn_ray(surface, sample->wi);
    return true;
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
  Ray ray_;
  Rgb radiance_{0};
  ScaleEstimate gathered_;
  float distance_ = 0;           // travelled since the camera
  Rgb throughput_{1};
  Medium medium_;
  float compression_ = 1;
  std::uint32_t depth_ = 0;
  bool last_delta_ = true;
  float last_pdf_ = 0;
  bool truncated_ = false;
  Vec3 last_position_{0};
};

}  // namespace

RadianceSample estimate_incoming(const PreparedScene& scene, const RadianceSettings& settings, const Ray& ray,
                                 CameraSampler& sampler) {
  return RadianceWalk(scene, settings, sampler, true).run(ray);
}

}  // namespace photond
