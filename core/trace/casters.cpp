#include "core/trace/casters.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "core/trace/gathered.h"
#include "core/trace/surface.h"

namespace photond {

namespace {

struct Piece {
  Vec3 a, b, c;
  Vec3 middle() const { return (a + b + c) / 3.0f; }
};

// Triangles that share a ball.
struct Cluster {
  std::span<Piece> pieces;
  Ball ball;
  int axis = 0;           // along which the middles of its pieces are spread most
  float spread = 0;
};

Cluster make_cluster(std::span<Piece> pieces) {
  Cluster cluster{pieces, {}, 0, 0};
  Bounds3 bounds, middles;
  for (const Piece& piece : pieces) {
    for (const Vec3& p : {piece.a, piece.b, piece.c}) bounds.add(p);
    middles.add(piece.middle());
  }
  cluster.ball.center = bounds.center();
  for (const Piece& piece : pieces) {
    for (const Vec3& p : {piece.a, piece.b, piece.c}) {
      cluster.ball.radius = std::max(cluster.ball.radius, glm::distance(p, cluster.ball.center));
    }
  }
  const Vec3 extent = middles.extent();
  for (int axis = 0; axis < 3; ++axis) {
    if (extent[axis] > cluster.spread) cluster.axis = axis, cluster.spread = extent[axis];
  }
  return cluster;
}

// The two parts on either side of the middle of the longest axis.
std::pair<Cluster, Cluster> split(const Cluster& cluster) {
  const int axis = cluster.axis;
  Bounds3 middles;
  for (const Piece& piece : cluster.pieces) middles.add(piece.middle());
  const float at = middles.center()[axis];
  const auto border = std::partition(cluster.pieces.begin(), cluster.pieces.end(),
                                     [&](const Piece& piece) { return piece.middle()[axis] < at; });
  const auto count = static_cast<std::size_t>(border - cluster.pieces.begin());
  return {make_cluster(cluster.pieces.first(count)), make_cluster(cluster.pieces.subspan(count))};
}

float area(const Ball& ball) { return ball.radius * ball.radius; }

// From here on a surface counts as metal.
constexpr float kMetal = 0.5f;

float alpha(float roughness) { return roughness * roughness; }

// Of a roughness texture's texels, RGBA, those of which `counts` says so.
template <class Texel, class Counts>
float lowest_roughness(float factor, std::span<const Texel> texels, const Counts& counts) {
  constexpr std::size_t kTexels = 1 << 20;
  constexpr float kScale = 1.0f / std::numeric_limits<Texel>::max();
  const std::size_t count = texels.size() / 4;
  const std::size_t step = (count + kTexels - 1) / kTexels | 1;   // odd: other columns in each row
  float lowest = kInfinity;
  for (std::size_t i = 0; i < count; i += step) {
    const bool such = counts(kScale * static_cast<float>(texels[4 * i + 2]));
    if (such) lowest = std::min(lowest, factor * kScale * static_cast<float>(texels[4 * i + 1]));
  }
  return lowest;
}

// `counts` is asked about the blue of each texel.
template <class Counts>
float lowest_roughness(const Scene& scene, float factor, const TextureSlot& slot, const Counts& counts) {
  const TextureImage& image = scene.images[scene.textures[slot.texture].image];
  return image.u16.empty() ? lowest_roughness(factor, std::span(image.u8), counts)
                           : lowest_roughness(factor, std::span(image.u16), counts);
}

// Of a clear coat, infinity where there is none.
float lowest_clearcoat_roughness(const Scene& scene, const Material& m) {
  if (m.clearcoat == 0) return kInfinity;
  if (!m.clearcoat_roughness_texture.used()) return m.clearcoat_roughness;
  return lowest_roughness(scene, m.clearcoat_roughness, m.clearcoat_roughness_texture, [](float) { return true; });
}

bool is_gloss(float alpha) { return alpha >= kSmoothAlpha && alpha < kGatherAlpha; }

// Which materials are such as `is` says.
template <class Is>
std::vector<bool> materials_that(const Scene& scene, const Is& is) {
  std::vector<bool> such;
  for (const Material& material : scene.materials) such.push_back(is(material));
  return such;
}

// Whether a surface of such a material is in the scene.
template <class Is>
bool any_surface(const Scene& scene, const Is& is) {
  const std::vector<bool> such = materials_that(scene, is);
  return std::any_of(scene.instances.begin(), scene.instances.end(),
                     [&](const Instance& instance) { return such[scene.meshes[instance.mesh].material]; });
}

std::vector<Piece> caster_pieces(const Scene& scene) {
  const std::vector<bool> bundles = materials_that(scene, [&](const Material& m) { return bundles_light(scene, m); });
  std::vector<Piece> pieces;
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    if (!bundles[mesh.material]) continue;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const TriangleVertices v = triangle_vertices(scene, i, t);
      pieces.push_back({v.a, v.b, v.c});
    }
  }
  return pieces;
}

}  // namespace

float lowest_roughness(const Scene& scene, const Material& m, float metallic) {
  if (m.metallic < metallic) return kInfinity;
  if (!m.metallic_roughness_texture.used()) return m.roughness;
  return lowest_roughness(scene, m.roughness, m.metallic_roughness_texture,
                          [&](float blue) { return m.metallic * blue >= metallic; });
}

bool bundles_light(const Scene& scene, const Material& m) {
  return m.transmission > 0 || alpha(lowest_roughness(scene, m, kMetal)) < kGatherAlpha;
}

bool casts_caustics(const Scene& scene, const Material& m) {
  // From this roughness on a highlight is too wide to be a caustic that only photons find.
  constexpr float kRough = 0.5f;
  return m.transmission > 0 || lowest_roughness(scene, m, kMetal) < kRough;
}

bool mirrors_points(const Scene& scene, const Material& m) {
  const float roughness = std::min(lowest_roughness(scene, m, 0), lowest_clearcoat_roughness(scene, m));
  return !m.bare_diffuse() && alpha(roughness) < kSmoothAlpha;
}

bool frosts(const Material& m) {
  return m.transmission > 0 && (m.metallic_roughness_texture.used() || m.anisotropy > 0 || alpha(m.roughness) >= kSmoothAlpha);
}

bool mirrors(const Scene& scene, const Material& m) {
  const float least = m.transmission > 0 ? lowest_roughness(scene, m, 0) : lowest_roughness(scene, m, kMetal);
  return alpha(least) < kSmoothAlpha;
}

bool lights_gloss(const Scene& scene) {
  const auto casts = [&](const Material& m) {
    return m.transmission > 0 || alpha(lowest_roughness(scene, m, kMetal)) < kSmoothAlpha;
  };
  const auto has_gloss = [&](const Material& m) {
    const bool glossy = m.metallic_roughness_texture.used() || is_gloss(alpha(m.roughness));
    const bool coat = m.clearcoat > 0 && (m.clearcoat_roughness_texture.used() || is_gloss(alpha(m.clearcoat_roughness)));
    return (glossy || coat) && m.transmission < 1 && !m.bare_diffuse();
  };
  return any_surface(scene, has_gloss) && any_surface(scene, casts);
}

bool environment_casts(const Scene& scene) {
  // From here on a path that leaves glass by chance finds too little of the environment's light too rarely: the squared
  // relative error of such a path.
  constexpr double kConcentrated = 20;
  if (!scene.environment.active() || scene.environment.concentration() <= kConcentrated) return false;
  return any_surface(scene, [&](const Material& m) { return casts_caustics(scene, m); });
}

std::vector<Ball> caster_balls(const Scene& scene, std::size_t most) {
  // Halves that together fill nearly as much as the whole are one thing, and hitting it is what counts.
  constexpr float kWorthwhile = 0.7f;
  std::vector<Piece> pieces = caster_pieces(scene);
  if (pieces.empty()) return {};
  std::vector<Cluster> open = {make_cluster(pieces)};
  std::vector<Ball> balls;
  while (!open.empty()) {
    const auto largest = std::max_element(open.begin(), open.end(), [](const Cluster& a, const Cluster& b) {
      return area(a.ball) < area(b.ball);
    });
    const Cluster cluster = *largest;
    open.erase(largest);
    const bool room = balls.size() + open.size() + 2 <= most;
    if (room && cluster.spread > 0) {
      const auto [low, high] = split(cluster);
      if (!low.pieces.empty() && !high.pieces.empty() &&
          area(low.ball) + area(high.ball) < kWorthwhile * area(cluster.ball)) {
        open.insert(open.end(), {low, high});
        continue;
      }
    }
    if (cluster.ball.radius > 0) balls.push_back(cluster.ball);
  }
  return balls;
}

}  // namespace photond
