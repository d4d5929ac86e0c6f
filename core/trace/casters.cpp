#include "core/trace/casters.h"

#include <algorithm>
#include <cmath>
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

std::vector<Piece> caster_pieces(const Scene& scene) {
  std::vector<Piece> pieces;
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    if (!bundles_light(scene.materials[mesh.material])) continue;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const TriangleVertices v = triangle_vertices(scene, i, t);
      pieces.push_back({v.a, v.b, v.c});
    }
  }
  return pieces;
}

}  // namespace

bool bundles_light(const Material& m) {
  const bool polished = m.roughness * m.roughness < kGatherAlpha || m.metallic_roughness_texture.used();
  return m.transmission > 0 || (m.metallic >= 0.5f && polished);
}

bool casts_caustics(const Material& m) {
  // From this roughness on a highlight is too wide to be a caustic that only photons find.
  constexpr float kRough = 0.5f;
  return m.transmission > 0 || (m.metallic >= 0.5f && m.roughness < kRough);
}

bool lights_gloss(const Scene& scene) {
  bool caster = false, gloss = false;
  for (const Instance& instance : scene.instances) {
    const Material& m = scene.materials[scene.meshes[instance.mesh].material];
    const bool textured = m.metallic_roughness_texture.used();
    const float alpha = m.roughness * m.roughness;
    caster = caster || m.transmission > 0 || (m.metallic >= 0.5f && alpha < kSmoothAlpha && !textured);
    const bool glossy = textured || (alpha >= kSmoothAlpha && alpha < kGatherAlpha);
    gloss = gloss || (glossy && m.transmission < 1 && !m.bare_diffuse());
  }
  return caster && gloss;
}

bool environment_casts(const Scene& scene) {
  // From here on a path that leaves glass by chance finds too little of the environment's light too rarely: the squared
  // relative error of such a path.
  constexpr double kConcentrated = 20;
  if (!scene.environment.active() || scene.environment.concentration() <= kConcentrated) return false;
  return std::any_of(scene.instances.begin(), scene.instances.end(), [&](const Instance& instance) {
    return casts_caustics(scene.materials[scene.meshes[instance.mesh].material]);
  });
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
