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

// How quickly the footprint of a path grows, in metres a metre, after a bounce that scatters: caustics that are seen by
// way of one are blurred by it anyway.
constexpr float kScatteredSpread = 0.1f;

// Vertices from the camera on at which smooth glass is followed both ways: a bright reflection on water is seen in
// every pass instead of in one of fifty.
constexpr std::uint32_t kSplitDepth = 2;

// Where a path stands, and what it carries.
struct PathState {
  Ray ray;
  Rgb throughput{1};
  float compression = 1;         // of radiance by the refractions so far
  float footprint = 0;           // metres across, at the ray's origin
  float spread = 0;              // what it grows by in a metre
  Medium medium;
  std::uint32_t depth = 0;
  bool last_delta = true;
  float last_pdf = 0;
  Vec3 last_position{0};
  // Technique::merge: whether photons bring light that is met from here on, too, because since the last gathered lobe
  // there were only followed ones (for `chained`: one at least), and the ratio of densities for an étendue of 1.
  bool scattered = false;
  bool chained = false;
  float ratio = 0;
};

// The lobes of a surface that take part in the estimation in two ways.
struct Lobes {
  LobeMask gathered = kNoLobe;   // where photons are gathered
  LobeMask followed = kNoLobe;   // the others
  float gathered_share = 0;      // probability with which a path goes on by a gathered lobe
  float followed_share = 1;
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
    const Lobes lobes = divide(bsdf);
    add_direct(surface, bsdf, lobes);
    path_.footprint += path_.spread * hit.t;
    Merge merge;
    if (lobes.gathered != kNoLobe) merge = add_indirect(surface, bsdf, lobes);
    return follow(surface, bsdf, lobes, merge);
  }

  Lobes divide(const Bsdf& bsdf) const {
    if (settings_.technique == Technique::trace) return {kNoLobe, bsdf.lobes(), 0, 1};
    const LobeMask gathered = gathered_lobes(bsdf);
    const LobeMask followed = bsdf.lobes() & ~gathered;
    if (settings_.technique != Technique::merge) return {gathered, followed, 0, 1};
    if (gathered == kNoLobe || followed == kNoLobe) return {gathered, followed, gathered != kNoLobe ? 1.0f : 0.0f, 1};
    const float share = bsdf.share(gathered);
    return {gathered, followed, share, 1 - share};
  }

  // The share of paths in light from a source of this étendue, against photons that arrive where the path scattered;
  // all where no photon can (an infinite or undefined ratio).
  static float share(bool chained, float ratio, float etendue) {
    const float rho = ratio * etendue;
    return chained && rho < kInfinity ? rho / (1 + rho) : 1;
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
    const float weight = hit_weight(pdf_direct) * share(path_.chained, path_.ratio, etendue);
    radiance_ += path_.throughput * scene_.scene.environment.from(direction) * weight;
  }

  void add_emission(const SurfacePoint& surface) {
    if (!see_emitters_ || !surface.material->emissive()) return;
    const Rgb emitted = emitted_radiance(scene_.scene, surface);
    if (is_black(emitted)) return;
    const bool sampled = path_.depth > 0 && !path_.last_delta;
    const float pdf_direct = sampled ? scene_.lights.pdf_direct(path_.last_position, surface) : 0;
    const float etendue = path_.chained ? scene_.lights.etendue(surface, -path_.ray.direction) : kInfinity;
    const float weight = hit_weight(pdf_direct) * share(path_.chained, path_.ratio, etendue);
    radiance_ += path_.throughput * emitted * weight;
  }

  // Next-event estimation: alone for lobes by which the path does not go on, weighted against going on for the others.
  void add_direct(const SurfacePoint& surface, const Bsdf& bsdf, const Lobes& lobes) {
    const LobeMask spread = lobes.followed & ~bsdf.delta_lobes();
    const LobeMask sampled = lobes.gathered | (see_emitters_ ? spread : kNoLobe);
    if (sampled == kNoLobe || scene_.lights.empty()) return;
    const Vec3 u(rng_.next4());
    const bool ends = lobes.gathered != kNoLobe && lobes.gathered_share == 0;
    if (!ends || !see_emitters_) {
      radiance_ += path_.throughput * direct(surface, bsdf, lobes, sampled, u);
      return;
    }
    // A path that ends in photons has cost much and sees light once: several points of the lights, evenly spread.
    static constexpr Vec3 kShifts[] = {{0, 0, 0}, {0.5f, 0.5f, 0.25f}, {0.25f, 0.75f, 0.5f}, {0.75f, 0.25f, 0.75f}};
    Rgb sum(0);
    for (const Vec3& shift : kShifts) sum += direct(surface, bsdf, lobes, sampled, glm::fract(u + shift));
    radiance_ += path_.throughput * (sum / static_cast<float>(std::size(kShifts)));
  }

  Rgb direct(const SurfacePoint& surface, const Bsdf& bsdf, const Lobes& lobes, LobeMask sampled, const Vec3& u) const {
    const DirectSample light = scene_.lights.sample_direct(scene_.scene, surface.position, u);
    if (is_black(light.radiance)) return Rgb(0);
    Rgb f(0);
    if (lobes.gathered != kNoLobe) {
      f += direct_weight(bsdf, light, lobes.gathered, lobes.gathered_share) *
           bsdf.eval(light.wi, lobes.gathered, Transport::radiance);
    }
    if (const LobeMask followed = sampled & lobes.followed; followed != kNoLobe) {
      f += direct_weight(bsdf, light, lobes.followed, lobes.followed_share) * direct_share(surface, light) *
           bsdf.eval(light.wi, followed, Transport::radiance);
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

  // MIS weight of sampled light against finding it by going on through `mask` with probability `share`.
  static float direct_weight(const Bsdf& bsdf, const DirectSample& light, LobeMask mask, float share) {
    if (share == 0 || light.pdf_w == 0) return 1;
    return power_heuristic(light.pdf_w, share * bsdf.pdf(light.wi, mask));
  }

  // The share of paths in light that a followed lobe sees.
  float direct_share(const SurfacePoint& surface, const DirectSample& light) const {
    if (!path_.scattered) return 1;
    const bool transmitted = glm::dot(light.wi, surface.ng) < 0;
    const float ratio = path_.ratio * (transmitted ? compression(*surface.material, surface.front) : 1);
    return share(true, ratio, light.etendue);
  }

  // Light that photons bring to the gathered lobes, and how it is shared with a path that goes on.
  Merge add_indirect(const SurfacePoint& surface, const Bsdf& bsdf, const Lobes& lobes) {
    const LobeMask mask = lobes.gathered;
    switch (settings_.technique) {
      case Technique::trace:
        break;
      case Technique::merge:
        return add_caustic(surface, bsdf, lobes);
      case Technique::density:
        add_density(*settings_.global, guide().global, surface, bsdf, mask);
        add_density(*settings_.caustic, guide().caustic, surface, bsdf, mask);
        break;
      case Technique::nearest:
        radiance_ += path_.throughput * (estimate(*settings_.global, surface, bsdf, mask) +
                                    estimate(*settings_.caustic, surface, bsdf, mask));
        break;
      case Technique::final_gather:
        radiance_ += path_.throughput * (estimate(*settings_.caustic, surface, bsdf, mask) + gather(surface, bsdf, mask));
        break;
    }
    return {};
  }

  void add_density(const PhotonMap& map, const Bandwidth& bandwidth, const SurfacePoint& surface, const Bsdf& bsdf,
                   LobeMask mask) {
    if (map.size() == 0) return;
    const float radius_sq = widest_radius_sq(settings_, bandwidth, surface.position, path_.footprint);
    if (radius_sq > 0) add_scales(map, radius_sq, surface, bsdf, mask, {}, gathered_);
  }

  Merge add_caustic(const SurfacePoint& surface, const Bsdf& bsdf, const Lobes& lobes) {
    const float widest_sq = widest_radius_sq(settings_, guide().caustic, surface.position, path_.footprint);
    if (!(widest_sq > 0)) return {kInfinity};
    // The radius that shares are reckoned with: in the middle of those that the picture may use.
    const float radius_sq = widest_sq / 16;
    Merge merge;
    if (scene_.lights.extended()) {
      merge.per_etendue = lobes.gathered_share / (static_cast<float>(settings_.emitted) * kPi * radius_sq);
    }
    const PhotonMap& map = *settings_.caustic;
    if (map.size() == 0) return merge;
    if (!path_.scattered) {
      add_scales(map, widest_sq, surface, bsdf, lobes.gathered, merge, gathered_);
    } else {
      ScaleEstimate sum;
      add_scales(map, radius_sq, surface, bsdf, lobes.gathered, merge, sum);
      radiance_ += sum.widest;
    }
    return merge;
  }

  void add_scales(const PhotonMap& map, float radius_sq, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask,
                  const Merge& merge, ScaleEstimate& sum) const {
    const Rgb scale = path_.throughput / static_cast<float>(settings_.emitted);
    const Reach reach(guide().edges, surface.position, surface.ng, std::sqrt(radius_sq));
    estimate_scales(map, surface, bsdf, mask, reach, radius_sq, scale, sum, merge);
  }

  const GatherGuide& guide() const {
    static const GatherGuide kNone;
    return settings_.guide != nullptr ? *settings_.guide : kNone;
  }

  Rgb estimate(const PhotonMap& map, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask) const {
    if (map.size() == 0) return Rgb(0);
    const float radius_sq = nearest_radius_sq(map, surface.position, settings_.nearest, settings_.radius_sq);
    if (!(radius_sq > 0)) return Rgb(0);
    const Reach reach(guide().edges, surface.position, surface.ng, std::sqrt(radius_sq));
    ScaleEstimate sum;
    estimate_scales(map, surface, bsdf, mask, reach, radius_sq, Rgb(1), sum);
    return sum.widest / static_cast<float>(settings_.emitted);
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
  PathState path_;
  std::array<PathState, kSplitDepth> branches_;   // waiting to be followed: one for each vertex that has split
  std::uint32_t waiting_ = 0;
  Rgb radiance_{0};
  ScaleEstimate gathered_;
  bool truncated_ = false;
};

}  // namespace

float widest_radius_sq(const RadianceSettings& settings, const Bandwidth& bandwidth, const Vec3& position,
                       float footprint) {
  static constexpr float kPhotons = 150;
  static constexpr float kFootprints = 24;
  if (settings.radius_sq > 0) return settings.radius_sq;
  const float widest = kFootprints * footprint;
  const float dense = bandwidth.radius_sq(position, kPhotons * settings.pilot_share);
  return settings.shrink * (dense > 0 ? std::min(dense, widest * widest) : widest * widest);
}

RadianceSample estimate_incoming(const PreparedScene& scene, const RadianceSettings& settings, const Ray& ray,
                                 CameraSampler& sampler) {
  return RadianceWalk(scene, settings, sampler, true).run(ray);
}

}  // namespace photond
