#pragma once

#include <cstdint>
#include <span>

#include "core/render/camera_sampler.h"
#include "core/scene/camera.h"

namespace photond {

/// Which pixels of a film, in rows from the top left, in which pass.
struct FilmBlock {
  int width = 1, height = 1;   ///< of the film
  std::uint64_t seed = 0;
  std::uint32_t pass = 0;
  std::uint64_t first = 0;     ///< pixel
};

/// A ray from the camera through each pixel of a block, with the sampler of the path that it begins. Both spans have the
/// block's length.
void film_rays(const Camera& camera, const FilmBlock& block, std::span<Ray> rays, std::span<CameraSampler> samplers);

}  // namespace photond
