// Jensen 1996; García et al. 2012: k-nearest normalization; Veach 1997, §5.3: shading normals.
#include "core/photon/estimate.h"

#include <algorithm>
#include <vector>

namespace photond {

namespace {

// Photons of surfaces turned by more than 60° are another surface's.
constexpr float kMinNormalCos = 0.5f;
// Bound of |wi·ns|/|wi·ng|, which grows without limit at grazing incidence on interpolated normals.
constexpr float kMaxNormalFactor = 8.0f;

}  // namespace

Rgb estimate_radiance(const PhotonMap& map, const SurfacePoint& surface, const Bsdf& bsdf, LobeMask mask,
                      float radius_sq) {
  glm::dvec3 sum(0);
  map.tree().query(surface.position, radius_sq, [&](std::uint32_t i, float distance_sq, float&) {
    if (glm::dot(map.normal(i), surface.ng) < kMinNormalCos) return;
    const Vec3 wi = map.direction(i);
    const float cos_g = glm::dot(wi, surface.ng);
    if (cos_g <= 0) return;
    float scale = epanechnikov(distance_sq, radius_sq);
    // Flux arrives per area of the true surface, the BSDF expects it per area of the shaded one.
    if (surface.smooth) scale *= std::min(std::abs(glm::dot(wi, surface.ns)) / cos_g, kMaxNormalFactor);
    sum += glm::dvec3(bsdf.eval(wi, mask, Transport::radiance) * map.flux(i) * scale);
  });
  return Rgb(sum);
}

float nearest_radius_sq(const PhotonMap& map, const Vec3& center, std::uint32_t k, float max_radius_sq) {
  thread_local std::vector<float> heap;  // the k smallest distances, largest first
  heap.clear();
  map.tree().query(center, max_radius_sq, [&](std::uint32_t, float distance_sq, float& radius_sq) {
    if (heap.size() == k) {
      std::pop_heap(heap.begin(), heap.end());
      heap.pop_back();
    }
    heap.push_back(distance_sq);
    std::push_heap(heap.begin(), heap.end());
    if (heap.size() == k) radius_sq = heap.front();
  });
  return heap.size() == k ? heap.front() : max_radius_sq;
}

}  // namespace photond
