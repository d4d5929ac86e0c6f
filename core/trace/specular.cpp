// Jensen 1996: photon tracing.
#include "core/trace/specular.h"

#include "core/trace/roulette.h"

namespace photond {

void SpecularBounces::scatter(std::uint32_t count) {
  surfaces.compute(count);
  const std::uint32_t end = whole_vectors(count);
  for (std::uint32_t i = 0; i < end; ++i) {
    const Vec3 in = surfaces.direction[i], n = surfaces.ns[i], ng = surfaces.ng[i];
    const bool clear = glass[i] != 0;
    const float eta = choose(surfaces.side[i] > 0, ior[i], 1 / ior[i]);
    const SpecularBounce bounce = specular_bounce(in, n, clear, eta, random[0][i]);
    const Rgb kept = flux[i] * choose(clear & (bounce.refracted == 0), Rgb(1), albedo[i]);
    const Rgb next = kept * shading_normal_factor(n, ng, in, bounce.out, kMostNormalFactor);
    const float survival = survival_probability(max_component(next) / max_component(flux[i]), depth[i]);
    const bool goes_on = bounce.valid(ng) & (random[1][i] < survival);
    settled[i] = far_from_flat(in, n, ng, choose(clear, eta, 1));
    next_flux.set(i, next * choose(goes_on, 1 / survival, 0));
    next_direction.set(i, bounce.out);
    origin.set(i, spawn_point(surfaces.position[i], ng, surfaces.extent[i], bounce.out));
    squeeze[i] = choose(bounce.refracted != 0, eta * eta, 1);
  }
}

}  // namespace photond
