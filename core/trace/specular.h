#pragma once

#include <cstdint>

#include "core/math/lanes.h"
#include "core/math/rng.h"
#include "core/math/warp.h"
#include "core/trace/microfacet.h"
#include "core/trace/surface.h"

namespace photond {

/// How light goes on from an ideal mirror or smooth glass.
struct SpecularBounce {
  Vec3 out;                      ///< unit, away from the surface
  std::uint32_t refracted;       ///< 1 or 0

  /// Whether it is on the side of a surface with that geometric normal where it belongs.
  bool valid(const Vec3& ng) const {
    const float above = glm::dot(out, ng);
    return choose(refracted != 0, -above, above) > 0;
  }
};

/// That of a unit direction `in` towards the surface, about its normal `n`. `eta` is the index beyond the surface over
/// that on the side of `in`; glass refracts where u in [0, 1) is not below the Fresnel reflectance.
[[gnu::always_inline]] inline SpecularBounce specular_bounce(const Vec3& in, const Vec3& n, bool glass, float eta, float u) {
  static constexpr float kMinCos = 1e-4f;   // as in Bsdf
  const float along = -glm::dot(in, n);
  const float cosine = std::max(along, kMinCos);
  float cos_t = 0;
  const float fresnel = fresnel_dielectric(cosine, eta, cos_t);
  const bool refracts = glass & (u >= fresnel);
  const float scale = choose(refracts, 1 / eta, 1);
  const float bend = choose(refracts, along / eta - cos_t, along + cosine);
  const Vec3 bent = scale * in + bend * n;
  return {bent * (1 / std::sqrt(glm::dot(bent, bent))), refracts};
}

/// Whether the shading normal `n` of a mirror or smooth glass is all that counts for light that travels along `in`:
/// wherever it may leave, by that normal or by the geometric one, paths from the eye do not take the surface as flat
/// (Bsdf::flat). So it is far from grazing and critical angles, in terms of how much n is tilted; nearer it is not told.
[[gnu::always_inline]] inline bool far_from_flat(const Vec3& in, const Vec3& n, const Vec3& ng, float eta) {
  const Vec3 tilt = glm::cross(n, ng);
  const float margin = 2 * std::sqrt(glm::dot(tilt, tilt));   // the sine of twice the tilt, at least
  const float cosine = glm::dot(in, ng);
  const float least_sq = margin * margin;
  const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
  // Sines of incidence on this side, where it is as oblique as tilted normals can make it, and of refraction.
  const float oblique = sine + std::max(eta, 1.0f) * margin;
  const float bent_most = (sine + margin) / eta, bent_least = std::max(sine - margin, 0.0f) / eta;
  const bool apart = oblique * oblique + least_sq < 1;
  return apart & ((bent_most * bent_most + least_sq < 1) | (bent_least > 1));
}

/// What corrects flux for a shading normal explodes at grazing incidence: in each pass it is bounded. Where normals are
/// tilted by 60° a bound of 8 cuts 3 % of the light off, which vanishes as the bound grows from pass to pass; so does what
/// a single photon adds to the mean of the passes.
inline float most_normal_factor(std::uint32_t pass) { return 8 * std::sqrt(1 + static_cast<float>(pass)); }

/// |wi·ns||wo·ng| / (|wi·ng||wo·ns|) for a photon's incoming direction `in` and outgoing direction `out`: what makes its
/// walk the adjoint of the camera's on interpolated normals [Veach 1997, §5.3]. At most `most`.
[[gnu::always_inline]] inline float shading_normal_factor(const Vec3& ns, const Vec3& ng, const Vec3& in, const Vec3& out,
                                                          float most) {
  const float above = std::abs(glm::dot(in, ns) * glm::dot(out, ng));
  const float below = std::abs(glm::dot(in, ng) * glm::dot(out, ns));
  return choose(above == below, 1, choose(below > 0, std::min(above / below, most), 0));
}

/// Photons that meet mirrors and smooth glass (Shading::mirror and glass), and how they leave.
struct alignas(64) SpecularBounces {
  // What comes in.
  SurfaceLanes surfaces;
  Vec3Lanes albedo;
  float ior[kLanes];
  std::uint32_t glass[kLanes];    ///< 1 or 0
  Vec3Lanes flux;
  std::uint32_t depth[kLanes];    ///< bounces before this one
  float random[2][kLanes];

  // What goes out.
  Vec3Lanes origin;              ///< of the next ray
  Vec3Lanes next_direction;
  Vec3Lanes next_flux;           ///< black where Russian roulette ends the path, or no direction is left
  float squeeze[kLanes];          ///< compression by refraction, else 1: what the path's étendue is to be divided by
  std::uint32_t settled[kLanes];  ///< 1, or 0 where what leaves the surface is not for this to find (far_from_flat)

  /// Fills lane k.
  void set(std::uint32_t k, const PlacedMesh& mesh, const Hit& hit, const Vec3& in, const Rgb& power,
           std::uint32_t bounces, Rng& rng) {
    surfaces.set(k, mesh, hit, in);
    albedo.set(k, mesh.albedo);
    ior[k] = mesh.ior;
    glass[k] = mesh.shading == Shading::glass;
    flux.set(k, power);
    depth[k] = bounces;
    for (auto& number : random) number[k] = rng.next();
  }
  /// Computes the first `count` bounces, surviving in proportion to what is kept.
  void scatter(std::uint32_t count);

  static constexpr float kMostNormalFactor = 8;   ///< of interpolated normals, which are hardly tilted
};

}  // namespace photond
