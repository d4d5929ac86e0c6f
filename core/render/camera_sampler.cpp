#include "core/render/camera_sampler.h"

namespace photond {

void SamplerLanes::next2(std::uint32_t count, float (&x)[kLanes], float (&y)[kLanes]) {
  const std::uint32_t end = whole_vectors(count);
  for (std::uint32_t i = 0; i < end; ++i) {
    const Vec2 u = sobol_2d(index[i], CameraSampler::seed(low[i], high[i], ++dimension[i]));
    x[i] = u.x;
    y[i] = u.y;
  }
}

}  // namespace photond
