// MacDonald, Booth 1990: heuristics for ray tracing using space subdivision.
#include "core/trace/cover.h"

#include <algorithm>

#include "core/math/rng.h"
#include "core/math/transform.h"
#include "core/math/warp.h"
#include "core/trace/crossing_rays.h"
#include "core/trace/overlap.h"

namespace photond {

namespace {

constexpr std::size_t kManyTriangles = std::size_t{1} << 16;
// Of the lines through the whole, where the parts are worth looking at.
constexpr float kMostLines = 0.6f;
constexpr std::size_t kBins = 8;   // places an axis where a part may be divided, and one more

Bounds3 join(const Bounds3& a, const Bounds3& b) { return {glm::min(a.min, b.min), glm::max(a.max, b.max)}; }

Bounds3 join(std::span<const Bounds3> boxes) {
  Bounds3 all;
  for (const Bounds3& box : boxes) all = join(all, box);
  return all;
}

// What lies in a face of the box is met by rays within that face, too.
Bounds3 widened(const Bounds3& box) {
  const Vec3 margin(0x1p-20f * std::max(max_component(glm::abs(box.min)), max_component(glm::abs(box.max))));
  return {box.min - margin, box.max + margin};
}

std::vector<Bounds3> boxes_of(const Scene& scene, std::span<const std::uint32_t> instances) {
  std::size_t count = 0;
  for (const std::uint32_t i : instances) count += scene.meshes[scene.instances[i].mesh].triangles.size();
  const std::vector<Bounds3> whole = instance_bounds(scene);
  std::vector<Bounds3> boxes;
  for (const std::uint32_t i : instances) {
    const Instance& instance = scene.instances[i];
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (count > kManyTriangles) {
      boxes.push_back(whole[i]);
      continue;
    }
    for (const glm::uvec3& triangle : mesh.triangles) {
      Bounds3& box = boxes.emplace_back();
      for (int k = 0; k < 3; ++k) box.add(transform_point(instance.to_world, mesh.positions[triangle[k]]));
    }
  }
  std::erase_if(boxes, [](const Bounds3& box) { return box.empty(); });
  return boxes;
}

// Some of the boxes, and where they are best divided in two.
struct Part {
  std::span<Bounds3> boxes;
  Bounds3 bounds;
  int axis = 0;
  float middle = 0;
  float gain = 0;   // 0 where they are better left together

  explicit Part(std::span<Bounds3> all) : boxes(all), bounds(join(all)) {
    for (int a = 0; a < 3; ++a) try_axis(a);
  }

  std::span<Bounds3> split() {
    const auto right = std::stable_partition(boxes.begin(), boxes.end(),
                                             [&](const Bounds3& box) { return box.center()[axis] < middle; });
    const std::span<Bounds3> rest(right, boxes.end());
    *this = Part(std::span(boxes.begin(), right));
    return rest;
  }

 private:
  static float cost(const Bounds3& box, std::size_t count) { return half_surface(box) * static_cast<float>(count); }

  void try_axis(int a) {
    const float from = bounds.min[a], step = bounds.extent()[a] / kBins;
    if (!(step > 0)) return;
    Bounds3 bins[kBins];
    std::size_t counts[kBins] = {};
    for (const Bounds3& box : boxes) {
      std::size_t bin = 0;
      while (bin + 1 < kBins && box.center()[a] >= from + step * static_cast<float>(bin + 1)) ++bin;
      bins[bin] = join(bins[bin], box);
      ++counts[bin];
    }
    Bounds3 left;
    std::size_t count = 0;
    for (std::size_t next = 1; next < kBins; ++next) {
      left = join(left, bins[next - 1]);
      count += counts[next - 1];
      if (count == 0 || count == boxes.size()) continue;
      const Bounds3 right = join(std::span(bins).subspan(next));
      const float saved = cost(bounds, boxes.size()) - cost(left, count) - cost(right, boxes.size() - count);
      if (saved > gain) {
        gain = saved;
        axis = a;
        middle = from + step * static_cast<float>(next);
      }
    }
  }
};

// From a point of the box's surface, cosine-weighted inwards: lines meet whatever is inside in proportion to its surface.
Ray line_through(const Bounds3& box, Rng& rng) {
  const Vec3 e = box.extent();
  const float faces[] = {e.y * e.z, e.z * e.x, e.x * e.y};   // across x, y and z
  float u = rng.next() * (faces[0] + faces[1] + faces[2]);
  int axis = 0;
  while (axis < 2 && u >= faces[axis]) u -= faces[axis++];
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  const bool low = rng.next() < 0.5f;
  const Vec2 place = rng.next2();
  const Vec3 local = square_to_cosine_hemisphere(rng.next2());
  Ray line;
  line.origin[axis] = low ? box.min[axis] : box.max[axis];
  line.origin[b] = box.min[b] + place.x * e[b];
  line.origin[c] = box.min[c] + place.y * e[c];
  line.direction[axis] = low ? local.z : -local.z;
  line.direction[b] = local.x;
  line.direction[c] = local.y;
  return line;
}

}  // namespace

Cover cover(const Scene& scene, std::span<const std::uint32_t> instances) {
  std::vector<Bounds3> boxes = boxes_of(scene, instances);
  if (boxes.empty()) return {};
  std::vector<Part> parts{Part(boxes)};
  const Bounds3 whole = parts.front().bounds;
  while (parts.size() < kCoverParts) {
    const auto worst = std::ranges::max_element(parts, {}, &Part::gain);
    if (!(worst->gain > 0)) break;
    const std::span<Bounds3> rest = worst->split();
    parts.emplace_back(rest);
  }
  Cover cover{widened(whole), {}};
  for (const Part& part : parts) cover.parts.push_back(widened(part.bounds));
  if (crossing_share(cover, whole) > kMostLines) cover.parts.clear();
  return cover;
}

float crossing_share(const Cover& cover, const Bounds3& world) {
  constexpr std::uint32_t kLines = 4096;
  static_assert(kLines % kLanes == 0);
  Rng rng(0, RngPurpose::pilot, 0, 0);
  std::uint32_t crossing = 0;
  RayLanes lines{};
  for (std::uint32_t i = 0; i < kLines; i += kLanes) {
    for (std::uint32_t k = 0; k < kLanes; ++k) lines.set(k, line_through(world, rng));
    crossing += CrossingRays(cover, lines, lines.t_max, kLanes).size();
  }
  return static_cast<float>(crossing) / kLines;
}

}  // namespace photond
