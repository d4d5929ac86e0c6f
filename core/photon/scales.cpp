// Jensen 1996: radiance estimate. Hachisuka, Jarosz and Jensen 2010: bias from two radii, variance within a pass.
#include "core/photon/scales.h"

#include <algorithm>
#include <bit>

namespace photond {

namespace {

// Photons of surfaces turned by more than 60° are another surface's.
constexpr float kMinNormalCos = 0.5f;
// Bound of |wi·ns|/|wi·ng|, which grows without limit at grazing incidence on interpolated normals.
constexpr float kMaxNormalFactor = 8.0f;

constexpr std::uint32_t kLeaf = PhotonLeaf::kSize;
template <class T>
using Lanes = PhotonLeaf::Lanes<T>;

// 4^k: what relative squared distances of the scale k are larger by than those of the widest.
constexpr float area_factor(int scale) { return static_cast<float>(1 << (2 * scale)); }

float smallest(const Lanes<float>& v) {
  std::array<float, kLeaf / 2> half;
  for (std::uint32_t i = 0; i < half.size(); ++i) half[i] = v[i] < v[i + half.size()] ? v[i] : v[i + half.size()];
  return std::min(std::min(half[0], half[2]), std::min(half[1], half[3]));
}
float total(const Lanes<float>& v) { return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7])); }

// The kernels of one gather: K_k(d) = height[k]·(1 − 4^k d²/r²) where that is positive.
struct Kernels {
  Vec3 center;
  Vec3 normal;
  float radius_sq;
  std::array<float, kScales> height;
  const Reach* reach;

  Kernels(const Vec3& center_, const Vec3& normal_, const Reach& reach_, float radius_sq_)
      : center(center_), normal(normal_), radius_sq(radius_sq_), reach(&reach_) {
    for (int k = 0; k < kScales; ++k) {
      const float r_sq = radius_sq / area_factor(k);
      height[k] = 2 * kInvPi / (r_sq * reach->coverage(r_sq));
    }
  }

  // d²/r² of the photons that count, 1 of all others.
  Lanes<float> relative_distances_sq(const PhotonLeaf& leaf) const {
    const Lanes<float> d = leaf.distances_sq(center);
    const float inverse = 1 / radius_sq;
    Lanes<float> t;
    for (std::uint32_t i = 0; i < kLeaf; ++i) {
      const float turned = glm::dot(decode_normal(leaf.normal[i]), normal);
      t[i] = (d[i] < radius_sq) & (turned >= kMinNormalCos) ? d[i] * inverse : 1;
    }
    if (!reach->whole()) drop_beyond_reach(leaf, t);
    return t;
  }

  void drop_beyond_reach(const PhotonLeaf& leaf, Lanes<float>& t) const {
    Lanes<float> limit_sq, across_sq;
    for (std::uint32_t i = 0; i < kLeaf; ++i) {
      const Vec3 offset(leaf.x[i] - center.x, leaf.y[i] - center.y, leaf.z[i] - center.z);
      limit_sq[i] = reach->limit_sq(offset, across_sq[i]);
    }
    for (std::uint32_t i = 0; i < kLeaf; ++i) t[i] = across_sq[i] < limit_sq[i] ? t[i] : 1;
  }
};

// Sums over a batch of leaves of weight times value at each scale, and of the squares of the weights' differences: few
// enough terms for floats.
struct BatchSums {
  std::array<std::array<Lanes<float>, 3>, kScales> level{};
  std::array<Lanes<float>, kBands> square{};

  // `value`: flux times BSDF of the leaf's photons, channel by channel; `nearest`: the smallest of `t`.
  void add(const Kernels& kernels, const Lanes<float>& t, float nearest, const std::array<Lanes<float>, 3>& value) {
    Lanes<float> value_sq;
    for (std::uint32_t i = 0; i < kLeaf; ++i) {
      value_sq[i] = value[0][i] * value[0][i] + value[1][i] * value[1][i] + value[2][i] * value[2][i];
    }
    Lanes<float> wider{};
    for (int k = 0; k < kScales; ++k) {
      const bool reached = nearest * area_factor(k) < 1;
      Lanes<float> weight{};
      if (reached) {
        for (std::uint32_t i = 0; i < kLeaf; ++i) {
          const float inside = 1 - t[i] * area_factor(k);
          weight[i] = (inside > 0 ? inside : 0) * kernels.height[k];
        }
        for (int c = 0; c < 3; ++c) {
          for (std::uint32_t i = 0; i < kLeaf; ++i) level[k][c][i] += weight[i] * value[c][i];
        }
      }
      if (k > 0) {
        for (std::uint32_t i = 0; i < kLeaf; ++i) {
          const float step = weight[i] - wider[i];
          square[k - 1][i] += step * step * value_sq[i];
        }
      }
      if (!reached) break;
      wider = weight;
    }
  }
};

// Sums over a whole gather.
struct Sums {
  std::array<glm::dvec3, kScales> level{};
  std::array<double, kBands> square{};

  void add(const BatchSums& batch) {
    for (int k = 0; k < kScales; ++k) {
      const auto& v = batch.level[k];
      level[k] += glm::dvec3(total(v[0]), total(v[1]), total(v[2]));
    }
    for (int j = 0; j < kBands; ++j) square[j] += total(batch.square[j]);
  }

  void add_to(ScaleEstimate& sum, const Rgb& scale) const {
    // Of the variance, which is summed over the channels, the factors' mean square: weighed as if all photons had the
    // colour of their sum.
    const Rgb light(level[0]);
    const float brightest = max_component(light);
    const Rgb hue = brightest > 0 ? light / brightest : Rgb(1);
    const float scale_sq = glm::dot(scale * hue, scale * hue) / glm::dot(hue, hue);
    Rgb wider(0);
    for (int k = 0; k < kScales; ++k) {
      const Rgb estimate = scale * Rgb(level[k]);
      if (k == 0) {
        sum.widest += estimate;
      } else {
        sum.bands.value[k - 1] += estimate - wider;
        sum.bands.variance[k - 1] += scale_sq * static_cast<float>(square[k - 1]);
      }
      wider = estimate;
    }
  }
};

std::array<Lanes<float>, 3> fluxes(const PhotonLeaf& leaf) {
  std::array<Lanes<float>, 3> flux;
  for (int c = 0; c < 3; ++c) {
    for (std::uint32_t i = 0; i < kLeaf; ++i) flux[c][i] = decode_flux(leaf.flux[c][i]);
  }
  return flux;
}

// The fluxes times the photons' shares 1/(1 + ρ), where ρ is `per_etendue` times the étendue.
std::array<Lanes<float>, 3> shares(const PhotonMap& map, std::uint32_t leaf, float per_etendue) {
  std::array<Lanes<float>, 3> flux = fluxes(map.leaf(leaf));
  const Lanes<float>& etendues = map.etendues(leaf);
  for (std::uint32_t i = 0; i < kLeaf; ++i) {
    const float share = 1 / (1 + per_etendue * etendues[i]);
    for (int c = 0; c < 3; ++c) flux[c][i] *= share;
  }
  return flux;
}

// Sums value(leaf, t) over the leaves where any photon counts.
template <class Value>
Sums sum_leaves(const PhotonMap& map, const Kernels& kernels, const Value& value) {
  Sums sums;
  map.tree().query(kernels.center, kernels.radius_sq, [&](std::span<const std::uint32_t> leaves) {
    BatchSums batch;
    for (const std::uint32_t i : leaves) {
      const PhotonLeaf& leaf = map.leaf(i);
      const Lanes<float> t = kernels.relative_distances_sq(leaf);
      const float nearest = smallest(t);
      if (nearest < 1) batch.add(kernels, t, nearest, value(i, t));
    }
    sums.add(batch);
  });
  return sums;
}

}  // namespace

void estimate_scales(const PhotonMap& map, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask,
                     const Reach& reach, float radius_sq, const Rgb& scale, ScaleEstimate& sum, const Merge& merge) {
  const Kernels kernels(surface.position, surface.ng, reach, radius_sq);
  const bool shared = merge.per_etendue > 0 && map.has_etendues();
  if (bsdf.lobes() == kDiffuseLobe && !surface.smooth) {
    // A bare Lambert base is the same for all directions: it waits until the end.
    const float per_etendue = merge.per_etendue * kInvPi;   // its density is the cosine over π
    const auto arriving = [&](std::uint32_t leaf, const Lanes<float>&) {
      return shared ? shares(map, leaf, per_etendue) : fluxes(map.leaf(leaf));
    };
    sum_leaves(map, kernels, arriving).add_to(sum, scale * bsdf.eval(surface.ns, mask, Transport::radiance));
    return;
  }
  const auto reflected = [&](std::uint32_t leaf_index, const Lanes<float>& t) {
    const PhotonLeaf& leaf = map.leaf(leaf_index);
    std::array<Lanes<float>, 3> value{};
    for (std::uint32_t i = 0; i < kLeaf; ++i) {
      if (!(t[i] < 1)) continue;
      const Vec3 wi = decode_direction(leaf.direction[i]);
      if (!(glm::dot(wi, surface.ng) > 0)) continue;   // a neighbouring facet's, from behind this one
      const Rgb f = bsdf.eval(wi, mask, Transport::radiance);
      // Flux arrives per area of the true surface, the BSDF expects it per area of the shaded one [Veach 1997, §5.3].
      const float cosines = std::abs(glm::dot(wi, surface.ns)) / glm::dot(wi, surface.ng);
      float factor = surface.smooth ? std::min(cosines, kMaxNormalFactor) : 1;
      if (shared) factor /= 1 + merge.ratio(surface, bsdf, mask, wi, map.etendues(leaf_index)[i]);
      for (int c = 0; c < 3; ++c) value[c][i] = factor * f[c] * decode_flux(leaf.flux[c][i]);
    }
    return value;
  };
  sum_leaves(map, kernels, reflected).add_to(sum, scale);
}

Rgb estimate_irradiance(const PhotonMap& map, const Vec3& position, const Vec3& normal, const Reach& reach,
                        float radius_sq) {
  const auto arriving = [&](std::uint32_t leaf, const Lanes<float>&) { return fluxes(map.leaf(leaf)); };
  return Rgb(sum_leaves(map, Kernels(position, normal, reach, radius_sq), arriving).level[0]);
}

}  // namespace photond
