// Jensen 1996: radiance estimate. Hachisuka, Jarosz and Jensen 2010: bias from two radii, variance within a pass.
#include "core/photon/scales.h"

#include <algorithm>
#include <bit>

#include "core/math/float8.h"
#include "core/trace/bsdf8.h"

namespace photond {

namespace {

// Photons of surfaces turned by more than 60° are another surface's.
constexpr float kMinNormalCos = 0.5f;

template <class T>
using Lanes = PhotonLeaf::Lanes<T>;
static_assert(sizeof(Lanes<float>) == sizeof(Float8));

// 4^k: what relative squared distances of the scale k are larger by than those of the widest.
constexpr float area_factor(int scale) { return static_cast<float>(1 << (2 * scale)); }

// The kernels of one gather: K_k(d) = height[k]·(1 − 4^k d²/r²)/r² where that is positive. The area is left to the end:
// its square is no float in the largest scenes and the smallest.
struct Kernels {
  Vec3 center;
  Vec3 normal;
  float radius_sq;
  std::array<float, kScales> height;
  const Reach* reach;

  Kernels(const Vec3& center_, const Vec3& normal_, const Reach& reach_, float radius_sq_)
      : center(center_), normal(normal_), radius_sq(radius_sq_), reach(&reach_) {
    for (int k = 0; k < kScales; ++k) {
      height[k] = 2 * kInvPi * area_factor(k) / reach->coverage(radius_sq / area_factor(k));
    }
  }

  // d²/r² of the photons that count, 1 of all others.
  [[gnu::always_inline]] Float8 relative_distances_sq(const PhotonLeaf& leaf) const {
    const Vec3x8 offset = Vec3x8{load8(leaf.x.data()), load8(leaf.y.data()), load8(leaf.z.data())} - center;
    const Float8 d = length_sq(offset.x, offset.y, offset.z);
    const Float8 turned = dot(normal, decode_normal(reinterpret_cast<Bits8>(load8(leaf.normal.data()))));
    Mask8 counts = (d < radius_sq) & (turned >= kMinNormalCos);
    if (!reach->whole()) counts &= reach->within(offset);
    return counts ? d * (1 / radius_sq) : Float8{} + 1;
  }
};

// Sums over a batch of leaves of weight times value at each scale, and of the squares of the weights' differences: few
// enough terms for floats.
struct BatchSums {
  std::array<Vec3x8, kScales> level{};
  std::array<Float8, kBands> square{};

  // `value`: flux times BSDF of the leaf's photons.
  [[gnu::always_inline]] void add(const Kernels& kernels, const Float8& t, const Vec3x8& value) {
    const Float8 value_sq = dot(value, value);
    Float8 wider{};
    for (int k = 0; k < kScales; ++k) {
      const Float8 inside = 1 - t * area_factor(k);
      const Mask8 reached = inside > 0;
      if (!any8(reached)) {
        if (k > 0) square[k - 1] += wider * wider * value_sq;
        break;
      }
      const Float8 weight = (reached ? inside : Float8{}) * kernels.height[k];
      level[k] = level[k] + value * weight;
      if (k > 0) square[k - 1] += (weight - wider) * (weight - wider) * value_sq;
      wider = weight;
    }
  }
};

// Sums over a whole gather, times r².
struct Sums {
  std::array<glm::dvec3, kScales> level{};
  std::array<double, kBands> square{};

  void add(const BatchSums& batch) {
    for (int k = 0; k < kScales; ++k) {
      const Vec3x8& v = batch.level[k];
      level[k] += glm::dvec3(sum8(v.x), sum8(v.y), sum8(v.z));
    }
    for (int j = 0; j < kBands; ++j) square[j] += sum8(batch.square[j]);
  }

  // `scale` in terms of 1/r².
  void add_to(ScaleEstimate& sum, const glm::dvec3& scale) const {
    // Of the variance, which is summed over the channels, the factors' mean square: weighed as if all photons had the
    // colour of their sum.
    const double brightest = std::max({level[0].x, level[0].y, level[0].z});
    const glm::dvec3 hue = brightest > 0 ? level[0] / brightest : glm::dvec3(1);
    const double scale_sq = glm::dot(scale * hue, scale * hue) / glm::dot(hue, hue);
    Rgb wider(0);
    for (int k = 0; k < kScales; ++k) {
      const Rgb estimate(scale * level[k]);
      if (k == 0) {
        sum.widest += estimate;
      } else {
        sum.bands.value[k - 1] += estimate - wider;
        sum.bands.variance[k - 1] += static_cast<float>(scale_sq * square[k - 1]);
      }
      wider = estimate;
    }
  }
};

[[gnu::always_inline]] inline Vec3x8 fluxes(const PhotonLeaf& leaf) {
  return {decode_flux(leaf.flux[0]), decode_flux(leaf.flux[1]), decode_flux(leaf.flux[2])};
}

// The photons' shares 1/(1 + ρ), where ρ is `per_etendue` times the étendue.
[[gnu::always_inline]] inline Float8 shares(const Lanes<float>& etendues, float per_etendue) {
  return 1 / (1 + per_etendue * load8(etendues.data()));
}

// The same at a surface of any kind, of the photons that count.
Float8 shares(const Merge& merge, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask, const PhotonMap& map,
              std::uint32_t leaf, const Mask8& counting) {
  Float8 shares{};
  for (std::uint32_t left = bits8(counting); left != 0; left &= left - 1) {
    const auto i = static_cast<std::uint32_t>(std::countr_zero(left));
    const Vec3 wi = decode_direction(map.leaf(leaf).direction[i]);
    shares[i] = 1 / (1 + merge.ratio(surface, bsdf, mask, wi, map.etendues(leaf)[i]));
  }
  return shares;
}

// Flux arrives per area of the true surface, the BSDF expects it per area of the shaded one [Veach 1997, §5.3].
[[gnu::always_inline]] inline Float8 normal_factors(const SurfacePoint& surface, const Vec3x8& wi, float most) {
  const Float8 along = dot(surface.ng, wi);
  const Float8 factors = min8(abs8(dot(surface.ns, wi)) / along, Float8{} + most);
  return along > 0 ? factors : Float8{};   // a neighbouring facet's, from behind this one
}

// Sums values(leaf, t) over the leaves where any photon counts.
template <class Values>
[[gnu::always_inline]] inline Sums sum_leaves(const PhotonMap& map, const Kernels& kernels, const Values& values) {
  Sums sums;
  map.tree().query(kernels.center, kernels.radius_sq, [&](std::span<const std::uint32_t> leaves) {
    BatchSums batch;
    for (const std::uint32_t i : leaves) {
      const Float8 t = kernels.relative_distances_sq(map.leaf(i));
      if (any8(t < 1)) batch.add(kernels, t, values(i, t));
    }
    sums.add(batch);
  });
  return sums;
}

}  // namespace

void estimate_scales(const PhotonMap& map, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask,
                     const Reach& reach, float radius_sq, const Rgb& scale, ScaleEstimate& sum, const Merge& merge,
                     float most_normal_factor) {
  const Kernels kernels(surface.position, surface.ng, reach, radius_sq);
  const bool shared = merge.per_etendue > 0 && map.has_etendues();
  const glm::dvec3 per_area = glm::dvec3(scale) / static_cast<double>(radius_sq);
  if (bsdf.lobes() == kDiffuseLobe && !surface.smooth) {
    // A bare Lambert base is the same for all directions: it waits until the end.
    const float per_etendue = merge.per_etendue * kInvPi;   // its density is the cosine over π
    const auto arriving = [&](std::uint32_t leaf, const Float8&) __attribute__((always_inline)) {
      const Vec3x8 flux = fluxes(map.leaf(leaf));
      return shared ? flux * shares(map.etendues(leaf), per_etendue) : flux;
    };
    const glm::dvec3 f(bsdf.eval(surface.ns, mask, Transport::radiance));
    sum_leaves(map, kernels, arriving).add_to(sum, per_area * f);
    return;
  }
  const Bsdf8 gathered(bsdf, mask);
  const auto reflected = [&](std::uint32_t leaf_index, const Float8& t) __attribute__((always_inline)) {
    const PhotonLeaf& leaf = map.leaf(leaf_index);
    const Vec3x8 wi = decode_direction(reinterpret_cast<Bits8>(load8(leaf.direction.data())));
    Vec3x8 value = gathered.eval(wi) * fluxes(leaf);
    if (surface.smooth) value = value * normal_factors(surface, wi, most_normal_factor);
    if (shared) value = value * shares(merge, surface, bsdf, mask, map, leaf_index, t < 1);
    return choose8(t < 1, value, Vec3x8{});
  };
  sum_leaves(map, kernels, reflected).add_to(sum, per_area);
}

Rgb estimate_irradiance(const PhotonMap& map, const Vec3& position, const Vec3& normal, const Reach& reach,
                        float radius_sq) {
  const auto arriving = [&](std::uint32_t leaf, const Float8&) __attribute__((always_inline)) {
    return fluxes(map.leaf(leaf));
  };
  const Sums sums = sum_leaves(map, Kernels(position, normal, reach, radius_sq), arriving);
  return Rgb(sums.level[0] / static_cast<double>(radius_sq));
}

}  // namespace photond
