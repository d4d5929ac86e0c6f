// Jensen 1996: photon map rendering. Veach 1997: multiple importance sampling.
#include "core/render/bounces.h"

#include "core/render/direct_light.h"
#include "core/render/gather.h"
#include "core/trace/dispersion.h"
#include "core/trace/gathered.h"

namespace photond {

namespace {

// How quickly the footprint of a path grows, in metres a metre, after a bounce that scatters: caustics that are seen by
// way of one are blurred by it anyway.
constexpr float kScatteredSpread = 0.1f;

// Vertices from the camera on at which smooth glass is followed both ways: a bright reflection on water is seen in
// every pass instead of in one of fifty.
constexpr std::uint32_t kSplitDepth = 2;

// MIS weight of light found by following a lobe, against sampling it from the previous vertex.
float hit_weight(const CameraPath& path, float pdf_direct) {
  return path.last_pdf == 0 ? 1 : power_heuristic(path.last_pdf, pdf_direct);
}

void continue_by(const Scene& scene, CameraPath& path, const SurfacePoint& surface, const BsdfSample& sample,
                 float share) {
  path.throughput *= sample.weight * share;
  if (sample.transmitted) {
    path.compression *= compression(surface);
    path.ratio *= compression(surface);
  }
  path.chained = path.shared;
  path.medium.cross(scene, surface, sample.transmitted);
  path.last_pdf = sample.pdf_w;
  path.ray = spawn_ray(surface, sample.wi);
}

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

// From the ray's end off the surface again; false where the path ends.
bool Bounces::advance(Walk& walk, const Hit& hit, SurfacePoint surface) {
  CameraPath& path = walk.path;
  path.throughput *= path.medium.transmittance(scene_.scene, surface, hit.t);
  add_emission(walk, surface, hit.t);
  // The last bounce's light may be found here as well as by sampling it from there: only now the path is cut.
  if (path.depth == settings_.max_depth) {
    samples_[walk.sample].truncated = true;
    return false;
  }
  if (disperses(*surface.material)) disperse(surface, path.throughput, settings_.wavelengths, walk.rng.next());
  surface.ior = path.medium.relative_index(scene_.scene, surface);
  const Bsdf bsdf(scene_.scene, surface, -path.ray.direction);
  const Lobes lobes = divide(bsdf, technique(path));
  sample_direct_light(scene_, path, surface, bsdf, lobes, walk.rng, walk.sample, shadows);
  path.footprint += path.spread * hit.t;
  Shares shares;
  if (lobes.gathered != kNoLobe) shares.gathered = add_indirect(walk, surface, bsdf, lobes);
  shares.at_gloss = shares_gloss(walk.path) && gloss_lobes(bsdf) != kNoLobe;
  if (shares.at_gloss) {
    shares.gloss = gather_caustic(settings_, scene_.lights, path, surface, bsdf, gloss_lobes(bsdf), lobes.followed_share,
                                  gathered_[walk.sample]);
  }
  return follow(walk, surface, bsdf, lobes, shares);
}

Technique Bounces::technique(const CameraPath& path) const {
  return path.gathering ? Technique::nearest : settings_.technique;
}

// Photons bring to the first gloss what they would bring to any that follows.
bool Bounces::shares_gloss(const CameraPath& path) const {
  const bool merging = settings_.technique == Technique::density || settings_.technique == Technique::merge;
  return scene_.shares_gloss && merging && !path.shared && !path.gathering;
}

void Bounces::add_environment(const Walk& walk) {
  const CameraPath& path = walk.path;
  if (path.gathering || !scene_.scene.environment.active()) return;
  const Vec3& direction = path.ray.direction;
  const float pdf_direct = path.depth > 0 ? scene_.lights.pdf_environment(scene_.scene, direction) : 0;
  const float etendue =
      path.chained ? scene_.lights.environment_etendue(pdf_direct, path.ray.origin, direction) : kInfinity;
  add(walk, scene_.scene.environment.from(direction) * (hit_weight(path, pdf_direct) * path.share(etendue)));
}

void Bounces::add_emission(const Walk& walk, const SurfacePoint& surface, float distance) {
  const CameraPath& path = walk.path;
  if (path.gathering || !surface.material->emissive()) return;
  const Rgb emitted = emitted_radiance(scene_.scene, surface);
  if (is_black(emitted)) return;
  const Vec3& direction = path.ray.direction;
  const float pdf_direct = path.last_pdf > 0 ? scene_.lights.pdf_direct(scene_.scene, surface, direction, distance) : 0;
  const float etendue = path.chained ? scene_.lights.etendue(scene_.scene, surface, -direction) : kInfinity;
  add(walk, emitted * (hit_weight(path, pdf_direct) * path.share(etendue)));
}

// Light that photons bring to the gathered lobes, and how it is shared with a path that goes on.
Merge Bounces::add_indirect(Walk& walk, const SurfacePoint& surface, const Bsdf& bsdf, const Lobes& lobes) {
  ScaleEstimate& gathered = gathered_[walk.sample];
  switch (technique(walk.path)) {
    case Technique::trace:
      break;
    case Technique::merge:
      return gather_caustic(settings_, scene_.lights, walk.path, surface, bsdf, lobes.gathered, lobes.gathered_share,
                            gathered);
    case Technique::density:
      gather_density(settings_, walk.path, surface, bsdf, lobes, gathered);
      break;
    case Technique::nearest:
      add(walk, gather_all(settings_, surface, bsdf, lobes));
      break;
    case Technique::final_gather:
      add(walk, gather_nearest(settings_, *settings_.caustic, surface, bsdf, lobes.gathered));
      gather(walk, surface, bsdf, lobes.gathered);
      break;
  }
  return {};
}

// Sends a final-gather ray on its own way.
void Bounces::gather(Walk& walk, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask) {
  const auto sample = bsdf.sample(Vec3(walk.rng.next4()), mask, Transport::radiance);
  if (!sample) return;
  Walk& branch = branch_off(walk);
  continue_by(scene_.scene, branch.path, surface, *sample, 1);
  branch.path.gathering = true;
}

bool Bounces::follow(Walk& walk, const SurfacePoint& surface, const Bsdf& bsdf, const Lobes& lobes,
                     const Shares& shares) {
  CameraPath& path = walk.path;
  if (lobes.followed == kNoLobe && lobes.gathered_share == 0) return false;
  if (path.depth < kSplitDepth && settings_.technique != Technique::trace) {
    const float reflected = bsdf.smooth_glass_reflectance();
    if (reflected > 0 && reflected < 1) return follow_both(walk, surface, bsdf, reflected);
  }
  Vec4 u = walk.rng.next4();
  const bool scatters = u.z < lobes.gathered_share;
  const float chosen = scatters ? lobes.gathered_share : lobes.followed_share;
  u.z = std::min((scatters ? u.z : u.z - lobes.gathered_share) / chosen, 0x1.fffffep-1f);
  const LobeMask mask = scatters ? lobes.gathered : lobes.followed;
  const auto sample = bsdf.sample(Vec3(u), mask, Transport::radiance);
  if (!sample) return false;
  continue_by(scene_.scene, path, surface, *sample, 1 / chosen);
  path.last_pdf *= chosen;
  if (scatters) {
    path.scattered = true;
    path.spread = std::max(path.spread, kScatteredSpread);
  }
  if (scatters || shares.at_gloss) {
    path.shared = true;
    path.chained = false;
    path.ratio = (scatters ? shares.gathered : shares.gloss).ratio(surface, bsdf, mask, sample->wi, 1);
  }
  const float survival = roulette_survival(path.throughput, path.compression, path.depth);
  path.throughput /= survival;
  return u.w < survival;
}

// Goes on by refraction and lets the reflection branch off, each with its share instead of by chance.
bool Bounces::follow_both(Walk& walk, const SurfacePoint& surface, const Bsdf& bsdf, float reflected) {
  const auto reflection = bsdf.sample({0, 0, 0}, kGlassLobe, Transport::radiance);
  const auto refraction = bsdf.sample({0, 0, 0x1.fffffep-1f}, kGlassLobe, Transport::radiance);
  if (reflection) continue_by(scene_.scene, branch_off(walk).path, surface, *reflection, reflected);
  if (refraction) continue_by(scene_.scene, walk.path, surface, *refraction, 1 - reflected);
  return refraction.has_value();
}

// A copy of the walk that goes on by itself, from the next bounce on.
Walk& Bounces::branch_off(Walk& walk) {
  Walk& branch = branches.emplace_back(walk);
  branch.rng = walk.rng.branch();
  ++branch.path.depth;
  return branch;
}

}  // namespace photond
