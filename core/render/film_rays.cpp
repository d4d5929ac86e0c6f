#include "core/render/film_rays.h"

#include <algorithm>

namespace photond {

namespace {

// Places on the film, and the rays through them.
struct alignas(64) FilmLanes {
  float column[kLanes], row[kLanes];           // of pixels
  float x[kLanes], y[kLanes];                  // where in them
  Vec3Lanes origin, direction;

  void look(const View& view, float width, float height, std::uint32_t count) {
    const std::uint32_t end = whole_vectors(count);
    for (std::uint32_t i = 0; i < end; ++i) {
      const Ray ray = view.ray({(column[i] + x[i]) / width, (row[i] + y[i]) / height});
      origin.set(i, ray.origin);
      direction.set(i, ray.direction);
    }
  }
};

}  // namespace

void film_rays(const Camera& camera, const FilmBlock& block, std::span<Ray> rays, std::span<CameraSampler> samplers) {
  const auto width = static_cast<float>(block.width), height = static_cast<float>(block.height);
  const View view(camera, width / height);
  const auto columns = static_cast<std::uint64_t>(block.width);
  std::uint64_t row = block.first / columns, column = block.first % columns;
  FilmLanes lanes{};
  SamplerLanes numbers{};
  for (std::size_t first = 0; first < rays.size(); first += kLanes) {
    const auto count = static_cast<std::uint32_t>(std::min<std::size_t>(kLanes, rays.size() - first));
    for (std::uint32_t k = 0; k < count; ++k) {
      samplers[first + k] = CameraSampler(block.seed, block.pass, block.first + first + k);
      numbers.set(k, samplers[first + k], 1);
      lanes.column[k] = static_cast<float>(column);
      lanes.row[k] = static_cast<float>(row);
      if (++column == columns) column = 0, ++row;
    }
    numbers.next2(count, lanes.x, lanes.y);
    lanes.look(view, width, height, count);
    for (std::uint32_t k = 0; k < count; ++k) rays[first + k] = {lanes.origin[k], lanes.direction[k]};
  }
}

}  // namespace photond
