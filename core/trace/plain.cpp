#include "core/trace/plain.h"

#include "core/math/frame.h"
#include "core/math/octahedral.h"
#include "core/math/warp.h"
#include "core/trace/roulette.h"
#include "core/trace/surface.h"

namespace photond {

void PlainBounces::scatter(std::uint32_t count) {
  const std::uint32_t end = whole_vectors(count);
  for (std::uint32_t i = 0; i < end; ++i) {
    const Vec3 in = direction[i];
    const FlatPoint p = at.point(i, in);
    const Vec3 local = square_to_cosine_hemisphere({random[0][i], random[1][i]});
    const Rgb reflected = flux[i] * albedo[i];
    const float survival = survival_probability(max_component(reflected) / max_component(flux[i]), depth[i]);
    const float chance = local.z > 0 ? survival : 0;
    const Rgb out = reflected * (random[2][i] < chance ? 1 / survival : 0);
    position.set(i, p.position);
    from[i] = encode_direction(-in);
    normal[i] = encode_normal(p.ng);
    origin.set(i, spawn_point(p.position, p.ng, p.extent, p.ng));
    next_direction.set(i, Frame(p.ng).to_world(local));
    next_flux.set(i, out);
    next_power[i] = (out.x + out.y + out.z) * (1.0f / 3);
  }
}

}  // namespace photond
