#include "core/render/preview.h"

#include <algorithm>
#include <cmath>

#include "core/film/reconstruct.h"

namespace photond {

namespace {

constexpr int kPixels = 44 * 44;
// A pass of fewer pixels than this is hardly longer than its preview.
constexpr int kWorthwhile = 16'384;

int pixels(const RenderSettings& settings) { return settings.width * settings.height; }

RenderTask coarse(const RenderTask& task) {
  RenderTask result = task;
  const double factor = std::sqrt(static_cast<double>(pixels(task.settings)) / kPixels);
  const auto shrunk = [factor](int n) { return std::max(1, static_cast<int>(std::lround(n / factor))); };
  result.settings.width = shrunk(task.settings.width);
  result.settings.height = shrunk(task.settings.height);
  return result;
}

// Where the pixel i of n stands among m: two neighbours and the second one's share.
struct Between {
  int first, second;
  float share;

  Between(int i, int n, int m) {
    const float place = (static_cast<float>(i) + 0.5f) * static_cast<float>(m) / static_cast<float>(n) - 0.5f;
    first = std::clamp(static_cast<int>(std::floor(place)), 0, m - 1);
    second = std::min(first + 1, m - 1);
    share = std::clamp(place - static_cast<float>(first), 0.0f, 1.0f);
  }
};

Image enlarge(const Image& image, int width, int height, const Execution& execution) {
  Image result(width, height);
  const auto pixel = [&](int x, int y) -> const Rgb& {
    return image.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                        static_cast<std::size_t>(x)];
  };
  parallel_for(execution, static_cast<std::size_t>(height), 16, [&](std::size_t row) {
    const Between y(static_cast<int>(row), height, image.height);
    for (int column = 0; column < width; ++column) {
      const Between x(column, width, image.width);
      const Rgb above = glm::mix(pixel(x.first, y.first), pixel(x.second, y.first), x.share);
      const Rgb below = glm::mix(pixel(x.first, y.second), pixel(x.second, y.second), x.share);
      result.pixels[row * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)] =
          glm::mix(above, below, y.share);
    }
  });
  return result;
}

}  // namespace

bool has_preview(const RenderTask& task) { return task.plan.uses_maps && pixels(task.settings) > kWorthwhile; }

Result<Image> render_preview(const RenderTask& task, const MapSource& maps, const Execution& execution) {
  const RenderTask small = coarse(task);
  const Result<PassImage> pass = render_pass(small, 0, maps, execution);
  if (!pass) return pass.error();
  Film film(small.settings.width, small.settings.height);
  add_pass(film, 0, *pass, execution);
  Image image = enlarge(film_picture(film, execution), task.settings.width, task.settings.height, execution);
  if (execution.cancelled()) return cancelled();
  return image;
}

}  // namespace photond
