#include "core/trace/scatter_flux.h"

#include <algorithm>
#include <cmath>

#include "core/math/warp.h"
#include "core/trace/gathered.h"
#include "core/trace/specular.h"

namespace photond {

namespace {

// Share of directions that are drawn about the true normal where there are other lobes than a Lambert one, in terms of
// the sine of the shading normal's tilt: so much light leaves where those never do.
constexpr float kTilted = 0.5f;

bool scatter_flat(const SurfacePoint& surface, const Bsdf& bsdf, const Vec3& wi, float most_normal_factor, const Vec3& u,
                  Rng& rng, FluxSample& out) {
  auto sample = bsdf.sample(u, kAllLobes, Transport::flux);
  if (!sample) return false;
  out.by_gathered = settle_gathered(bsdf, gathered_lobes(bsdf), rng, *sample);
  out.wi = sample->wi;
  out.weight = sample->weight;
  out.transmitted = sample->transmitted;
  if (surface.smooth && !sample->flat) {   // of a delta lobe
    out.weight *= shading_normal_factor(bsdf.normal(sample->lobe), surface.ng, wi, out.wi, most_normal_factor);
  }
  return true;
}

// How directions are drawn from lobes that are spread: by the BSDF, or about the true normal.
struct Spread {
  const SurfacePoint& surface;
  const Bsdf& bsdf;
  LobeMask lobes;
  float around;          // share of the latter

  Spread(const SurfacePoint& at, const Bsdf& of, LobeMask spread) : surface(at), bsdf(of), lobes(spread) {
    const float cosine = std::abs(glm::dot(at.ns, at.ng));
    around = spread == kDiffuseLobe ? 1 : kTilted * std::sqrt(std::max(0.0f, 1 - cosine * cosine));
  }

  bool transmits() const { return (lobes & kGlassLobe) != 0; }

  bool draw(const Vec3& u, Rng& rng, Vec3& out) const {
    if (around == 1 || rng.next() < around) {
      const Vec3 local = square_to_cosine_hemisphere(Vec2(u));
      out = Frame(transmits() && u.z < 0.5f ? -surface.ng : surface.ng).to_world(local);
      return true;
    }
    const auto sample = bsdf.sample(u, lobes, Transport::flux);
    if (sample) out = sample->wi;
    return sample.has_value();
  }

  float pdf(const Vec3& out) const {
    const float along = glm::dot(out, surface.ng);
    const float cosine = transmits() ? 0.5f * std::abs(along) : std::max(along, 0.0f);
    // What the BSDF draws below the true horizon, it rejects.
    const bool drawn = around < 1 && along * glm::dot(out, surface.ns) > 0;
    return around * cosine * kInvPi + (drawn ? (1 - around) * bsdf.pdf(out, lobes) : 0);
  }
};

// What the surface shows to a path that arrives along `out`, of light from `wi`.
struct Shown {
  Rgb gathered{0}, others{0};
  float cosine;          // of the light, by the shading normal that such a path sees

  Shown(const Scene& scene, const SurfacePoint& surface, const Bsdf& bsdf, const Vec3& wi, const Vec3& out) {
    const SurfacePoint seen = seen_from(scene, surface, out);
    cosine = glm::dot(wi, seen.ns);
    if (bsdf.lobes() == kDiffuseLobe) {
      if (cosine > 0) gathered = bsdf.diffuse_albedo() * kInvPi;
      return;
    }
    const Bsdf eye(scene, seen, out);
    const LobeMask gathering = gathered_lobes(eye);
    gathered = eye.eval(wi, gathering, Transport::radiance);
    others = eye.eval(wi, kAllLobes & ~gathering, Transport::radiance);
  }
};

bool scatter_spread(const Scene& scene, const Spread& spread, const Vec3& wi, float most_normal_factor, const Vec3& u,
                    Rng& rng, FluxSample& out) {
  const SurfacePoint& surface = spread.surface;
  if (!spread.draw(u, rng, out.wi)) return false;
  const Shown shown(scene, surface, spread.bsdf, wi, out.wi);
  const float factor = std::min(std::abs(shown.cosine / glm::dot(wi, surface.ng)), most_normal_factor);
  const float along = glm::dot(out.wi, surface.ng);
  out.transmitted = along < 0;
  out.weight = (shown.gathered + shown.others) * (factor * std::abs(along) / spread.pdf(out.wi));
  out.by_gathered = settle(shown.gathered, shown.others, rng, out.weight);
  return max_component(out.weight) > 0;
}

}  // namespace

bool scatter_flux(const Scene& scene, const SurfacePoint& surface, const Bsdf& bsdf, const Vec3& wi,
                  float most_normal_factor, Rng& rng, FluxSample& out) {
  const Vec2 u = rng.next2();
  const float choice = rng.next();
  const LobeMask spread = bsdf.lobes() & ~bsdf.delta_lobes();
  if (!surface.smooth || spread == kNoLobe) {
    return scatter_flat(surface, bsdf, wi, most_normal_factor, {u, choice}, rng, out);
  }
  const float share = bsdf.share(spread);
  const bool by_spread = choice < share;
  const float part = by_spread ? share : 1 - share;
  const float rest = std::min((by_spread ? choice : choice - share) / part, 0x1.fffffep-1f);
  if (by_spread) {
    if (!scatter_spread(scene, {surface, bsdf, spread}, wi, most_normal_factor, {u, rest}, rng, out)) return false;
  } else {
    const auto sample = bsdf.sample({u, rest}, bsdf.delta_lobes(), Transport::flux);
    if (!sample) return false;
    out = {sample->wi, sample->weight, sample->transmitted, false};
    if (!sample->flat) {
      out.weight *= shading_normal_factor(bsdf.normal(sample->lobe), surface.ng, wi, sample->wi, most_normal_factor);
    }
  }
  out.weight /= part;
  return true;
}

}  // namespace photond
