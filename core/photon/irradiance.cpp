// Christensen 1999: precomputed irradiance. Jensen 1996: k-nearest estimates.
#include "core/photon/irradiance.h"

#include <cmath>
#include <limits>
#include <vector>

#include "core/photon/nearest.h"
#include "core/photon/scales.h"

namespace photond {

namespace {

// Places of surfaces turned by more than 26° are another surface's, or too far along a curved one.
constexpr float kMinNormalCos = 0.9f;

// Flux per m² that the photons of `map` bring.
Rgb arriving(const PhotonMap& map, const Vec3& position, const Vec3& normal, const Edges& edges, float reach) {
  const float radius_sq = nearest_radius_sq(map, position, Irradiance::kNearest, reach * reach);
  if (!(radius_sq > 0)) return Rgb(0);
  const Reach cut(edges, position, normal, std::sqrt(radius_sq));
  return estimate_irradiance(map, position, normal, cut, radius_sq);
}

// Looks for the nearest place.
class Search {
 public:
  Search(const PhotonMap& places, const Vec3& position, const Vec3& normal)
      : places_(places), position_(position), normal_(normal) {}

  // Among those near along the curve.
  void look_near() {
    const std::uint32_t middle = places_.near_leaf(position_);
    const std::uint32_t end = std::min(middle + 2, places_.leaf_count());
    for (std::uint32_t leaf = middle - std::min(middle, 1u); leaf < end; ++leaf) add(leaf, Reach());
  }

  // Among all that are nearer than `radius_sq` and before every edge; whether there is one.
  bool look_around(float radius_sq, const Reach& reach) {
    found_sq_ = kInfinity;
    places_.tree().query(position_, radius_sq, [&](std::span<const std::uint32_t> leaves) {
      for (const std::uint32_t leaf : leaves) add(leaf, reach);
    });
    return found_sq_ < radius_sq;
  }

  bool found_any() const { return found_sq_ < kInfinity; }
  std::uint32_t found() const { return found_; }
  // What is nearer than the one found, and itself.
  float bound_sq() const { return std::max(found_sq_ * BoxTree::kSafety, std::numeric_limits<float>::min()); }
  Vec3 offset() const { return places_.position(found_) - position_; }

 private:
  void add(std::uint32_t number, const Reach& reach) {
    const PhotonLeaf& leaf = places_.leaf(number);
    const PhotonLeaf::Lanes<float> d = leaf.distances_sq(position_);
    for (std::uint32_t i = 0; i < PhotonLeaf::kSize; ++i) {
      const std::uint32_t at = number * PhotonLeaf::kSize + i;
      const bool nearer = d[i] < found_sq_ || (d[i] == found_sq_ && at < found_);
      if (!nearer || glm::dot(decode_normal(leaf.normal[i]), normal_) < kMinNormalCos) continue;
      if (!reach.whole() && !reach.within(Vec3(leaf.x[i], leaf.y[i], leaf.z[i]) - position_)) continue;
      found_ = at;
      found_sq_ = d[i];
    }
  }

  const PhotonMap& places_;
  Vec3 position_;
  Vec3 normal_;
  std::uint32_t found_ = 0;
  float found_sq_ = kInfinity;
};

}  // namespace

Irradiance::Irradiance(std::span<const PhotonMap* const> maps, double emitted, std::span<const PhotonMap* const> at,
                       const Edges& edges, float reach, const Execution& execution)
    : reach_(reach) {
  std::vector<Photon> places;
  for (const PhotonMap* from : at) {
    const std::size_t first = places.size();
    places.resize(first + from->size());
    parallel_for(execution, from->size(), 64, [&](std::size_t i) {
      const auto photon = static_cast<std::uint32_t>(i);
      Photon& place = places[first + i];
      place = {.position = from->position(photon), .normal = from->normal_bits(photon)};
      const Vec3 normal = glm::normalize(from->normal(photon));
      Rgb sum(0);
      for (const PhotonMap* map : maps) sum += arriving(*map, place.position, normal, edges, reach);
      place.flux = nearest_flux(sum / static_cast<float>(emitted));
    });
  }
  places_ = PhotonMap(places, execution);
}

std::optional<std::uint32_t> Irradiance::nearest(const Edges& edges, const Vec3& position, const Vec3& normal) const {
  if (places_.size() == 0) return std::nullopt;
  const float reach_sq = reach_ * reach_;
  Search search(places_, position, normal);
  search.look_near();
  float radius_sq = std::min(search.found_any() ? search.bound_sq() : reach_sq / 4096, reach_sq);
  while (!search.look_around(radius_sq, Reach())) {
    if (radius_sq == reach_sq) return std::nullopt;
    radius_sq = std::min(radius_sq * 16, reach_sq);
  }
  // Mostly no edge is as near as that.
  radius_sq = search.bound_sq();
  Reach reach(edges, position, normal, std::sqrt(radius_sq));
  if (reach.whole() || reach.within(search.offset())) return search.found();
  do {
    if (radius_sq >= reach_sq) return std::nullopt;
    radius_sq = std::min(radius_sq * 4, reach_sq);
    reach = Reach(edges, position, normal, std::sqrt(radius_sq));
  } while (!search.look_around(radius_sq, reach));
  return search.found();
}

std::optional<Rgb> Irradiance::at(const Edges& edges, const Vec3& position, const Vec3& normal) const {
  const auto place = nearest(edges, position, normal);
  return place ? std::optional(places_.flux(*place)) : std::nullopt;
}

}  // namespace photond
