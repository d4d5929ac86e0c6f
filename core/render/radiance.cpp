// Jensen 1996: photon map rendering. Veach 1997: multiple importance sampling.
#include "core/render/radiance.h"

#include <array>
#include <cmath>

#include "core/render/camera_path.h"
#include "core/render/direct_light.h"
#include "core/render/gather.h"
#include "core/trace/gathered.h"
#include "core/trace/roulette.h"

namespace photond {

namespace {

// Bounces before roulette starts on camera paths, whose first vertices carry most of the picture.
constexpr std::uint32_t kRouletteDepth = 4;

// How quickly the footprint of a path grows, in metres a metre, after a bounce that scatters: caustics that are seen by
// way of one are blurred by it anyway.
constexpr float kScatteredSpread = 0.1f;

// Vertices from the camera on at which smooth glass is followed both ways: a bright reflection on water is seen in
// every pass instead of in one of fifty.
constexpr std::uint32_t kSplitDepth = 2;

// One walk from the camera (or from a gather point) through the scene.
class RadianceWalk {
 public:
  // `see_emitters`: emission met, and light sampled for followed lobes, belongs to this walk. A final-gather ray
  // leaves both to its origin's direct light and caustics.
  RadianceWalk(const PreparedScene& scene, const RadianceSettings& settings, CameraSampler& rng, bool see_emitters)
      : scene_(scene), settings_(settings), rng_(rng), see_emitters_(see_emitters) {}

  RadianceSample run(const Ray& ray) {
    path_.ray = ray;
    path_.footprint = settings_.pixel_width;
    path_.spread = settings_.pixel_spread;
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
    const Lobes lobes = divide(bsdf, settings_.technique);
    radiance_ += path_.throughput * sample_direct_light(scene_, path_, surface, bsdf, lobes, see_emitters_, rng_);
    path_.footprint += path_.spread * hit.t;
    Merge merge;
    if (lobes.gathered != kNoLobe) merge = add_indirect(surface, bsdf, lobes);
    return follow(surface, bsdf, lobes, merge);
  }

  // MIS weight of light found by following a lobe, against sampling it from the previous vertex.
  float hit_weight(float pdf_direct) const {
    return path_.depth == 0 || path_.last_delta ? 1 : power_heuristic(path_.last_pdf, pdf_direct);
  }

  void add_environment() {
    if (!see_emitters_ || !scene_.scene.environment.active()) return;
    const Vec3& direction = path_.ray.direction;
    const float pdf_direct = path_.depth > 0 ? scene_.lights.pdf_environment(scene_.scene, direction) : 0;
    const float etendue =
        path_.chained ? scene_.lights.environment_etendue(pdf_direct, path_.ray.origin, direction) : kInfinity;
    const float weight = hit_weight(pdf_direct) * path_.share(etendue);
    radiance_ += path_.throughput * scene_.scene.environment.from(direction) * weight;
  }

  void add_emission(const SurfacePoint& surface) {
    if (!see_emitters_ || !surface.material->emissive()) return;
    const Rgb emitted = emitted_radiance(scene_.scene, surface);
    if (is_black(emitted)) return;
    const bool sampled = path_.depth > 0 && !path_.last_delta;
    const float pdf_direct = sampled ? scene_.lights.pdf_direct(path_.last_position, surface) : 0;
    const float etendue = path_.chained ? scene_.lights.etendue(surface, -path_.ray.direction) : kInfinity;
    const float weight = hit_weight(pdf_direct) * path_.share(etendue);
    radiance_ += path_.throughput * emitted * weight;
  }

  // Light that photons bring to the gathered lobes, and how it is shared with a path that goes on.
  Merge add_indirect(const SurfacePoint& surface, const Bsdf& bsdf, const Lobes& lobes) {
    switch (settings_.technique) {
      case Technique::trace:
        break;
      case Technique::merge:
        return gather_caustic(settings_, scene_.lights, path_, surface, bsdf, lobes, gathered_);
      case Technique::density:
        gather_density(settings_, path_, surface, bsdf, lobes, gathered_);
        break;
      case Technique::nearest:
        radiance_ += path_.throughput * (gather_nearest(settings_, *settings_.global, surface, bsdf, lobes) +
                                         gather_nearest(settings_, *settings_.caustic, surface, bsdf, lobes));
        break;
      case Technique::final_gather:
        radiance_ += path_.throughput * (gather_nearest(settings_, *settings_.caustic, surface, bsdf, lobes) +
                                         gather(surface, bsdf, lobes.gathered));
        break;
    }
    return {};
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

  bool follow(const SurfacePoint& surface, const Bsdf& bsdf, const Lobes& lobes, const Merge& merge) {
    if (lobes.followed == kNoLobe && lobes.gathered_share == 0) return false;
    if (path_.depth < kSplitDepth && settings_.technique != Technique::trace) {
      const float reflected = bsdf.smooth_glass_reflectance();
      if (reflected > 0 && reflected < 1) return follow_both(surface, bsdf, reflected);
    }
    Vec4 u = rng_.next4();
    const bool scatters = u.z < lobes.gathered_share;
    const float chosen = scatters ? lobes.gathered_share : lobes.followed_share;
    u.z = std::min((scatters ? u.z : u.z - lobes.gathered_share) / chosen, 0x1.fffffep-1f);
    const LobeMask mask = scatters ? lobes.gathered : lobes.followed;
    const auto sample = bsdf.sample(Vec3(u), mask, Transport::radiance);
    if (!sample) return false;
    continue_by(surface, *sample, 1 / chosen);
    path_.last_pdf *= chosen;
    if (scatters) {
      path_.scattered = true;
      path_.chained = false;
      path_.ratio = merge.ratio(surface, bsdf, mask, sample->wi, 1);
      path_.spread = std::max(path_.spread, kScatteredSpread);
    }
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
    const CameraPath before = path_;
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
    if (sample.transmitted) {
      path_.compression *= compression(*surface.material, surface.front);
      path_.ratio *= compression(*surface.material, surface.front);
    }
    path_.chained = path_.scattered;
    path_.medium.cross(surface, sample);
    path_.last_delta = sample.delta;
    path_.last_pdf = sample.pdf_w;
    path_.last_position = surface.position;
    path_.ray = spawn_ray(surface, sample.wi);
  }

  const PreparedScene& scene_;
  const RadianceSettings& settings_;
  CameraSampler& rng_;
  bool see_emitters_;
  CameraPath path_;
  std::array<CameraPath, kSplitDepth> branches_;   // waiting to be followed: one for each vertex that has split
  std::uint32_t waiting_ = 0;
  Rgb radiance_{0};
  ScaleEstimate gathered_;
  bool truncated_ = false;
};

}  // namespace

Lobes divide(const Bsdf& bsdf, Technique technique) {
  if (technique == Technique::trace) return {kNoLobe, bsdf.lobes(), 0, 1};
  const LobeMask gathered = gathered_lobes(bsdf);
  const LobeMask followed = bsdf.lobes() & ~gathered;
  if (technique != Technique::merge) return {gathered, followed, 0, 1};
  if (gathered == kNoLobe || followed == kNoLobe) return {gathered, followed, gathered != kNoLobe ? 1.0f : 0.0f, 1};
  const float share = bsdf.share(gathered);
  return {gathered, followed, share, 1 - share};
}

RadianceSample estimate_incoming(const PreparedScene& scene, const RadianceSettings& settings, const Ray& ray,
                                 CameraSampler& sampler) {
  return RadianceWalk(scene, settings, sampler, true).run(ray);
}

}  // namespace photond
