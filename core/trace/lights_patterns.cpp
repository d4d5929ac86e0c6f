// How strongly emitters of textures or alpha shine, and from where.
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "core/math/warp.h"
#include "core/scene/texture.h"
#include "core/trace/lights.h"

namespace photond {

namespace {

constexpr std::uint32_t kLeastSide = 4, kMostSide = 128;   // of a triangle's cells
constexpr std::size_t kMostCells = std::size_t{1} << 18;   // of all triangles; if the least are more, none is kept
constexpr std::uint32_t kLeastLooks = 2, kMostLooks = 4;   // along each side of a cell

// How many texels of what is in the slot the triangle shows.
double texels(const Scene& scene, const TextureSlot& slot, const Mesh& mesh, const glm::uvec3& vertices) {
  const auto& uv = mesh.uv[slot.uv_set];
  if (!slot.used() || uv.empty()) return 0;
  const TextureImage& image = scene.images[scene.textures[slot.texture].image];
  const glm::mat2 turned(slot.uv_transform);
  const Vec2 b = turned * (uv[vertices.y] - uv[vertices.x]), c = turned * (uv[vertices.z] - uv[vertices.x]);
  return 0.5 * std::abs(static_cast<double>(b.x) * c.y - static_cast<double>(b.y) * c.x) * image.width * image.height;
}

// What is shown of the textures that the emission depends on.
double texels(const Scene& scene, const Mesh& mesh, const Material& material, std::uint32_t triangle) {
  const glm::uvec3& vertices = mesh.triangles[triangle];
  const double emission = texels(scene, material.emission_texture, mesh, vertices);
  if (material.alpha_mode == AlphaMode::opaque) return emission;
  return std::max(emission, texels(scene, material.base_color_texture, mesh, vertices));
}

// How many cells it takes along each side to have one for a texel: a triangle is half of a square.
// Coordinates that are no numbers read as 0, which is one texel; here they count as many.
std::uint32_t fine_side(double texels) {
  constexpr double kMostTexels = 1e9;
  return static_cast<std::uint32_t>(std::ceil(std::sqrt(2 * (texels < kMostTexels ? texels : kMostTexels))));
}

std::uint32_t side_of(std::uint32_t fine, std::uint32_t most) {
  return std::bit_ceil(std::clamp(fine, kLeastSide, most));
}

std::size_t count_cells(std::span<const std::uint32_t> fine, std::uint32_t most) {
  std::size_t count = 0;
  for (const std::uint32_t side : fine) count += std::size_t{side_of(side, most)} * side_of(side, most);
  return count;
}

}  // namespace

// The mean over RGB of the radiance that leaves the front, for each cell.
std::vector<float> Lights::look_at_cells(const Scene& scene, std::uint32_t light, std::uint32_t side,
                                         std::uint32_t per_cell) const {
  std::vector<float> cells(std::size_t{side} * side);
  const std::uint32_t looks = side * per_cell;
  const double weight = 1.0 / (per_cell * per_cell * 3);
  for (std::uint32_t y = 0; y < looks; ++y) {
    for (std::uint32_t x = 0; x < looks; ++x) {
      const Vec2 u = (Vec2(x, y) + 0.5f) / static_cast<float>(looks);
      const Rgb radiance = emitted(scene, light, square_to_triangle(u), true);
      const double sum = static_cast<double>(radiance.x) + radiance.y + radiance.z;
      cells[std::size_t{y / per_cell} * side + x / per_cell] += static_cast<float>(weight * sum);
    }
  }
  return cells;
}

void Lights::measure_uneven(const Scene& scene) {
  std::vector<std::uint32_t> uneven, fine;
  for (std::uint32_t i = 0; i < emitters_.size(); ++i) {
    const Material& material = scene.materials[emitters_[i].material];
    if (material.shines_evenly()) continue;
    uneven.push_back(i);
    fine.push_back(fine_side(texels(scene, scene.meshes[scene.instances[lights_[i].instance].mesh], material,
                                    lights_[i].index)));
  }
  if (uneven.empty()) return;
  std::uint32_t most = kMostSide;
  while (most > kLeastSide && count_cells(fine, most) > kMostCells) most /= 2;
  const bool kept = count_cells(fine, most) <= kMostCells;
  if (kept) pattern_of_.assign(emitters_.size(), 0);
  for (std::size_t i = 0; i < uneven.size(); ++i) {
    const std::uint32_t light = uneven[i], side = side_of(fine[i], most);
    const std::uint32_t looks = std::clamp((2 * fine[i] + side - 1) / side, kLeastLooks, kMostLooks);
    const std::vector<float> cells = look_at_cells(scene, light, side, kept ? looks : 1);
    const double mean = std::accumulate(cells.begin(), cells.end(), 0.0) / static_cast<double>(cells.size());
    powers_[light] = mean * power_per_radiance(scene, light);
    total_power_ += powers_[light];
    EmissionPattern pattern;
    if (kept) pattern = EmissionPattern(side, cells);
    if (pattern.even()) continue;
    pattern_of_[light] = static_cast<std::uint32_t>(patterns_.size());
    patterns_.push_back(std::move(pattern));
  }
}

}  // namespace photond
