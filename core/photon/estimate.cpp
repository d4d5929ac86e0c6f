// Jensen 1996; García et al. 2012: k-nearest normalization; Veach 1997, §5.3: shading normals. Hachisuka, Jarosz and
// Jensen 2010: error from the photons themselves.
#include "core/photon/estimate.h"

#include <algorithm>
#include <cassert>
#include <numeric>

namespace photond {

namespace {

// Photons of surfaces turned by more than 60° are another surface's.
constexpr float kMinNormalCos = 0.5f;
// Bound of |wi·ns|/|wi·ng|, which grows without limit at grazing incidence on interpolated normals.
constexpr float kMaxNormalFactor = 8.0f;

constexpr std::uint32_t kLeaf = PhotonLeaf::kSize;
template <class T>
using Lanes = PhotonLeaf::Lanes<T>;

// The part of a surface whose photons are summed.
struct Disc {
  Vec3 center;
  Vec3 normal;
  float radius_sq;

  // d²/r² of the photons on the disc, 1 for all others.
  Lanes<float> relative_distances_sq(const PhotonLeaf& leaf) const {
    const Lanes<float> d = leaf.distances_sq(center);
    const float inverse = 1 / radius_sq;
    constexpr float kBelowOne = 0x1.fffffep-1f;   // the product may round up to 1
    Lanes<float> t;
    for (std::uint32_t i = 0; i < kLeaf; ++i) {
      const bool on_disc = d[i] < radius_sq && glm::dot(decode_normal(leaf.normal[i]), normal) >= kMinNormalCos &&
                           glm::dot(octahedral_vector(leaf.direction[i]), normal) > 0;
      t[i] = on_disc ? std::min(d[i] * inverse, kBelowOne) : 1;
    }
    return t;
  }
};

// What an estimate sums of each photon, over the flux; without the kernel's 2/(πr²).
struct Weights {
  float kernel;
  float difference;    // kernel of r less kernel of r/√2

  explicit Weights(float t) : kernel(1 - t), difference(kernel - (t < 0.5f ? 2 - 4 * t : 0)) {}
};

// Sums of a batch of leaves, lane by lane: few enough terms for floats.
struct LaneSums {
  std::array<Lanes<float>, 3> radiance{}, difference{}, square{};
  Lanes<std::uint32_t> count{};

  void add(const PhotonLeaf& leaf, const Lanes<float>& t) {
    for (std::uint32_t i = 0; i < kLeaf; ++i) {
      const Weights weights(t[i]);
      count[i] += t[i] < 1 ? 1 : 0;
      for (int c = 0; c < 3; ++c) {
        const float flux = decode_flux(leaf.flux[c][i]);
        const float term = weights.kernel * flux;
        radiance[c][i] += term;
        difference[c][i] += weights.difference * flux;
        square[c][i] += term * term;
      }
    }
  }
};

// Sums of a whole query.
struct Sums {
  glm::dvec3 radiance{0}, difference{0}, square{0};
  std::uint32_t count = 0;

  void add(const LaneSums& lanes) {
    const auto total = [](const Lanes<float>& v) { return std::accumulate(v.begin(), v.end(), 0.0); };
    for (int c = 0; c < 3; ++c) {
      radiance[c] += total(lanes.radiance[c]);
      difference[c] += total(lanes.difference[c]);
      square[c] += total(lanes.square[c]);
    }
    count += std::accumulate(lanes.count.begin(), lanes.count.end(), 0u);
  }

  void add(const Rgb& flux, float t) {
    const Weights weights(t);
    const glm::dvec3 term(weights.kernel * flux);
    radiance += term;
    difference += glm::dvec3(weights.difference * flux);
    square += term * term;
    ++count;
  }

  RadianceEstimate estimate(const Rgb& factor) const {
    RadianceEstimate result{Rgb(radiance), Rgb(difference), Rgb(square), count};
    return result *= factor;
  }
};

// Where the BSDF does not depend on directions it waits until the end.
Sums sum_flux(const PhotonMap& map, const Disc& disc) {
  Sums sums;
  map.tree().query(disc.center, disc.radius_sq, [&](std::span<const std::uint32_t> leaves) {
    LaneSums lanes;
    for (const std::uint32_t leaf : leaves) lanes.add(map.leaf(leaf), disc.relative_distances_sq(map.leaf(leaf)));
    sums.add(lanes);
  });
  return sums;
}

// Sums reflected(photon), the flux of a photon times the BSDF.
template <class Reflected>
Sums sum_reflected(const PhotonMap& map, const Disc& disc, const Reflected& reflected) {
  Sums sums;
  map.tree().query(disc.center, disc.radius_sq, [&](std::span<const std::uint32_t> leaves) {
    for (const std::uint32_t leaf : leaves) {
      const Lanes<float> t = disc.relative_distances_sq(map.leaf(leaf));
      for (std::uint32_t i = 0; i < kLeaf; ++i) {
        if (t[i] < 1) sums.add(reflected(leaf * kLeaf + i), t[i]);
      }
    }
  });
  return sums;
}

// The k-th smallest of non-negative numbers, bit by bit: as ordered as their bits, and counted without a branch.
float kth_smallest(std::span<const float> values, std::uint32_t k) {
  std::uint32_t low = 0;
  std::uint32_t high = std::bit_cast<std::uint32_t>(kInfinity);
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2;
    std::uint32_t count = 0;
    for (const float value : values) count += std::bit_cast<std::uint32_t>(value) <= middle ? 1 : 0;
    (count >= k ? high : low) = count >= k ? middle : middle + 1;
  }
  return std::bit_cast<float>(low);
}

// Photons per k among which the search is first bounded.
constexpr std::uint32_t kWindow = 2;

// The k smallest distances below a radius.
class Nearest {
 public:
  Nearest(const Vec3& center, std::uint32_t k, float radius_sq) : center_(center), k_(k), radius_sq_(radius_sq) {}

  void add(const PhotonLeaf& leaf) {
    if (count_ + kLeaf > found_.size()) keep_k();
    for (const float d : leaf.distances_sq(center_)) {
      found_[count_] = d;
      count_ += d < radius_sq_ ? 1 : 0;
    }
  }

  // Forgets the photons but for the radius they give.
  void start_again() {
    radius_sq_ = std::min(radius_sq_, kth() * BoxTree::kSafety);
    count_ = 0;
  }

  float radius_sq() const { return radius_sq_; }

  // The k-th distance; the radius where there are fewer.
  float kth() const { return count_ < k_ ? radius_sq_ : kth_smallest({found_.data(), count_}, k_); }

 private:
  void keep_k() {
    std::nth_element(found_.begin(), found_.begin() + (k_ - 1), found_.begin() + count_);
    count_ = k_;
  }

  Vec3 center_;
  std::uint32_t k_;
  float radius_sq_;
  std::uint32_t count_ = 0;
  std::array<float, 3 * kMaxNearest> found_;
};

}  // namespace

RadianceEstimate& RadianceEstimate::operator+=(const RadianceEstimate& other) {
  radiance += other.radiance;
  bias_half += other.bias_half;
  variance += other.variance;
  count += other.count;
  return *this;
}

RadianceEstimate& RadianceEstimate::operator*=(const Rgb& factor) {
  radiance *= factor;
  bias_half *= factor;
  variance *= factor * factor;
  return *this;
}

RadianceEstimate estimate_radiance(const PhotonMap& map, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask,
                                   float radius_sq) {
  const Disc disc{surface.position, surface.ng, radius_sq};
  const float peak = epanechnikov(0, radius_sq);
  if (bsdf.lobes() == kDiffuseLobe && (mask & kDiffuseLobe) != 0 && !surface.smooth) {
    // A bare Lambert base is the same for all directions.
    return sum_flux(map, disc).estimate(peak * bsdf.eval(surface.ns, kDiffuseLobe, Transport::radiance));
  }
  const auto reflected = [&](std::uint32_t photon) {
    const Vec3 wi = map.direction(photon);
    Rgb flux = bsdf.eval(wi, mask, Transport::radiance) * map.flux(photon);
    // Flux arrives per area of the true surface, the BSDF expects it per area of the shaded one.
    if (surface.smooth) {
      flux *= std::min(std::abs(glm::dot(wi, surface.ns)) / glm::dot(wi, surface.ng), kMaxNormalFactor);
    }
    return flux;
  };
  return sum_reflected(map, disc, reflected).estimate(Rgb(peak));
}

float nearest_radius_sq(const PhotonMap& map, const Vec3& center, std::uint32_t k, float max_radius_sq) {
  assert(k >= 1 && k <= kMaxNearest);
  if (map.size() < k) return max_radius_sq;
  Nearest nearest(center, k, max_radius_sq);
  const std::uint32_t window = kWindow * k / kLeaf + 4;
  const std::uint32_t near = map.near_leaf(center);
  const std::uint32_t begin = near - std::min(near, window / 2);
  const std::uint32_t end = std::min(begin + window, map.leaf_count());
  for (std::uint32_t leaf = begin; leaf < end; ++leaf) nearest.add(map.leaf(leaf));
  nearest.start_again();
  map.tree().query(center, nearest.radius_sq(), [&](std::span<const std::uint32_t> leaves) {
    for (const std::uint32_t leaf : leaves) nearest.add(map.leaf(leaf));
  });
  return nearest.kth();
}

}  // namespace photond
