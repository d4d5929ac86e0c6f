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

bool scatter_flat(const Bsdf& bsdf, const Vec3& u, Rng& rng, FluxSample& out) {
  auto sample = bsdf.sample(u, kAllLobes, Transport::flux);
  if (!sample) return false;
  out.by_gathered = settle_gathered(bsdf, gathered_lobes(bsdf), rng, *sample);
  out.wi = sample->wi;
  out.weight = sample->weight;
  out.transmitted = sample->transmitted;
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

// Where light may leave by delta lobes, and what it carries there.
struct Exit {
  BsdfSample sample;
  Rgb weight{0};         // black where no path from the eye sees it

  explicit Exit(const std::optional<BsdfSample>& drawn) {
    if (drawn) sample = *drawn;
  }
  float power() const { return max_component(weight); }
};

// How a path from the eye that arrives where light leaves by a delta lobe sees that lobe.
struct Seen {
  bool flat;
  Vec3 normal;           // on the side of the photon

  Seen(const Scene& scene, const SurfacePoint& surface, const BsdfSample& sample) {
    const SurfacePoint seen = seen_from(scene, surface, sample.wi);
    const Bsdf eye(scene, seen, sample.wi);
    flat = eye.flat(sample.lobe);
    normal = sample.transmitted ? -eye.normal(sample.lobe) : eye.normal(sample.lobe);
  }
};

bool alike(const Vec3& a, const Vec3& b) { return glm::dot(a, b) > 1 - 1e-6f; }

Exit about_shading_normal(const Scene& scene, const SurfacePoint& surface, const Bsdf& bsdf, const Vec3& wi,
                          float most_normal_factor, const Vec3& u, bool& settled) {
  Exit exit(bsdf.about_shading_normal().sample(u, bsdf.delta_lobes(), Transport::flux));
  settled = false;
  if (exit.sample.lobe == kNoLobe) return exit;
  const Vec3& n = bsdf.normal(exit.sample.lobe);
  settled = far_from_flat(-wi, n, surface.ng, bsdf.bending_index());
  if (!settled) {
    const Seen seen(scene, surface, exit.sample);
    if (seen.flat || !alike(seen.normal, n)) return exit;
  }
  exit.weight = exit.sample.weight * shading_normal_factor(n, surface.ng, wi, exit.sample.wi, most_normal_factor);
  return exit;
}

Exit about_geometric_normal(const Scene& scene, const SurfacePoint& surface, const Bsdf& bsdf, const Vec3& u) {
  Exit exit(bsdf.about_geometric_normal().sample(u, bsdf.delta_lobes(), Transport::flux));
  if (exit.sample.lobe == kNoLobe) return exit;
  const Seen seen(scene, surface, exit.sample);
  const bool without_shading = alike(seen.normal, surface.ng) && !alike(bsdf.normal(exit.sample.lobe), surface.ng);
  if (seen.flat || without_shading) exit.weight = exit.sample.weight;
  return exit;
}

// The adjoint of a rule: paths from the eye take the surface as flat where the shading normal would send them through
// it. So some light leaves twice, once about either normal, and some never.
bool scatter_delta(const Scene& scene, const SurfacePoint& surface, const Bsdf& bsdf, const Vec3& wi,
                   float most_normal_factor, const Vec3& u, Rng& rng, FluxSample& out) {
  bool settled = false;
  const Exit shading = about_shading_normal(scene, surface, bsdf, wi, most_normal_factor, u, settled);
  // By the same numbers light leaves by the same lobe.
  const Exit flat = settled ? Exit({}) : about_geometric_normal(scene, surface, bsdf, u);
  const float sum = shading.power() + flat.power();
  if (!(sum > 0)) return false;
  const float p = shading.power() / sum;
  const bool by_shading = p == 1 || (p > 0 && rng.next() < p);
  const Exit& exit = by_shading ? shading : flat;
  out = {exit.sample.wi, exit.weight / (by_shading ? p : 1 - p), exit.sample.transmitted, false};
  return true;
}

}  // namespace

bool scatter_flux(const Scene& scene, const SurfacePoint& surface, const Bsdf& bsdf, const Vec3& wi,
                  float most_normal_factor, Rng& rng, FluxSample& out) {
  const Vec2 u = rng.next2();
  const float choice = rng.next();
  const LobeMask spread = bsdf.lobes() & ~bsdf.delta_lobes();
  if (!surface.smooth) return scatter_flat(bsdf, {u, choice}, rng, out);
  const float share = bsdf.share(spread);
  const bool by_spread = choice < share;
  const float part = by_spread ? share : 1 - share;
  const float rest = std::min((by_spread ? choice : choice - share) / part, 0x1.fffffep-1f);
  const bool scattered =
      by_spread ? scatter_spread(scene, {surface, bsdf, spread}, wi, most_normal_factor, {u, rest}, rng, out)
                : scatter_delta(scene, surface, bsdf, wi, most_normal_factor, {u, rest}, rng, out);
  out.weight /= part;
  return scattered;
}

}  // namespace photond
