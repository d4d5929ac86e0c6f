#include <cmath>

#include "scenes.h"

namespace photond::samples {
namespace {

constexpr float kHalfX = 1.6f, kHalfZ = 1.2f;  // of the basin
constexpr float kRim = 1.05f, kWater = 0.9f;   // heights above its floor
constexpr float kTile = 0.2f, kGap = 0.012f;

struct Wave {
  Vec2 k;  // 2π/wavelength × direction
  float amplitude, phase;
};
constexpr Wave kWaves[] = {{{9.2f, 3.1f}, 0.0085f, 0.3f},   {{-5.7f, 8.4f}, 0.0075f, 1.9f},
                           {{14.3f, -9.6f}, 0.0032f, 4.1f}, {{-12.1f, -15.8f}, 0.0026f, 2.6f},
                           {{3.3f, 5.2f}, 0.0090f, 5.0f},   {{23.0f, 7.5f}, 0.0012f, 0.8f}};

/// The water's surface, a little larger than the basin so that no light passes beside it.
Shape water_surface() {
  constexpr int kX = 224, kZ = 168;
  constexpr float kOverlap = 0.02f;
  Shape shape;
  for (int j = 0; j <= kZ; ++j) {
    for (int i = 0; i <= kX; ++i) {
      const Vec2 p((2.0f * i / kX - 1) * (kHalfX + kOverlap), (2.0f * j / kZ - 1) * (kHalfZ + kOverlap));
      float height = kWater;
      Vec2 slope(0);
      for (const Wave& wave : kWaves) {
        const float phase = glm::dot(wave.k, p) + wave.phase;
        height += wave.amplitude * std::sin(phase);
        slope += wave.amplitude * std::cos(phase) * wave.k;
      }
      shape.positions.emplace_back(p.x, height, p.y);
      shape.normals.push_back(glm::normalize(Vec3(-slope.x, 1, -slope.y)));
    }
  }
  for (std::uint32_t j = 0; j < kZ; ++j) {
    for (std::uint32_t i = 0; i < kX; ++i) {
      const std::uint32_t a = j * (kX + 1) + i, b = a + 1, c = a + kX + 1, d = c + 1;
      shape.triangles.emplace_back(a, c, d);
      shape.triangles.emplace_back(a, d, b);
    }
  }
  return shape;
}

/// Tiles with gaps, a little above the plane through `corner` spanned by `u` and `v`, in two colours.
void add_tiles(Shape (&colors)[2], const Vec3& corner, const Vec3& u, const Vec3& v) {
  const Vec3 x = glm::normalize(u), y = glm::normalize(v), lift = 0.002f * glm::cross(x, y);
  const int columns = static_cast<int>(std::lround(glm::length(u) / kTile));
  const int rows = static_cast<int>(std::floor(glm::length(v) / kTile + 0.01f));
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      const Vec3 at = corner + lift + (i * kTile + kGap / 2) * x + (j * kTile + kGap / 2) * y;
      append(colors[(i * 7 + j * 3) % 5 < 2 ? 1 : 0], quad(at, (kTile - kGap) * x, (kTile - kGap) * y));
    }
  }
}

void add_basin(Glb& glb) {
  const Vec3 x(2 * kHalfX, 0, 0), y(0, kRim, 0), z(0, 0, 2 * kHalfZ);
  const Vec3 corner(-kHalfX, 0, -kHalfZ);
  struct Side {
    Vec3 corner, u, v;
  };
  const Side sides[] = {
      {corner + z, x, -z}, {corner, x, y}, {corner + z + x, -x, y}, {corner + z, -z, y}, {corner + x, z, y}};
  Shape grout, tiles[2];
  for (const Side& side : sides) {
    append(grout, quad(side.corner, side.u, side.v));
    add_tiles(tiles, side.corner, side.u, side.v);
  }
  glb.add("grout", grout, glb.lambert("grout", Rgb(0.62f, 0.66f, 0.66f)));
  glb.add("light tiles", tiles[0], glb.lambert("light tile", {0.36f, 0.64f, 0.7f}));
  glb.add("dark tiles", tiles[1], glb.lambert("dark tile", {0.13f, 0.42f, 0.56f}));
}

void add_deck(Glb& glb) {
  constexpr float kFar = 4, kWidth = kFar - kHalfX, kDepth = kFar - kHalfZ;
  const int stone = glb.lambert("sandstone", {0.56f, 0.47f, 0.36f});
  const int coping = glb.lambert("coping", {0.7f, 0.67f, 0.62f});
  Shape deck;
  append(deck, quad({-kFar, kRim, -kHalfZ}, {2 * kFar, 0, 0}, {0, 0, -kDepth}));
  append(deck, quad({-kFar, kRim, kFar}, {2 * kFar, 0, 0}, {0, 0, -kDepth}));
  append(deck, quad({-kFar, kRim, kHalfZ}, {kWidth, 0, 0}, {0, 0, -2 * kHalfZ}));
  append(deck, quad({kHalfX, kRim, kHalfZ}, {kWidth, 0, 0}, {0, 0, -2 * kHalfZ}));
  glb.add("deck", deck, stone);
  Shape walls;
  append(walls, quad({-kFar, kRim, -kFar}, {2 * kFar, 0, 0}, {0, 2.4f, 0}));
  append(walls, quad({-kFar, kRim, kFar}, {0, 0, -2 * kFar}, {0, 2.4f, 0}));
  glb.add("courtyard walls", walls, glb.lambert("clay plaster", {0.62f, 0.4f, 0.29f}));
  constexpr float kHalf = 0.11f, kThick = 0.03f;
  for (float side : {-1.0f, 1.0f}) {
    glb.add("coping", box({0, kRim + kThick, side * (kHalfZ + kHalf)}, {kHalfX + 2 * kHalf, kThick, kHalf}),
            coping);
    glb.add("coping", box({side * (kHalfX + kHalf), kRim + kThick, 0}, {kHalf, kThick, kHalfZ}), coping);
  }
}

/// A floating ball whose segments alternate in colour.
void add_ball(Glb& glb) {
  constexpr std::uint32_t kSegments = 6;
  const int colors[] = {glb.lambert("white", Rgb(0.78f)), glb.lambert("red", {0.66f, 0.07f, 0.05f})};
  const Shape whole = sphere({0.55f, kWater + 0.1f, 0.25f}, 0.2f, 48);
  Shape parts[2] = {whole, whole};
  for (Shape& part : parts) part.triangles.clear();
  for (const glm::uvec3& t : whole.triangles) {
    const std::uint32_t column = std::min({t.x % 97, t.y % 97, t.z % 97});
    parts[column * kSegments / 96 % 2].triangles.push_back(t);
  }
  glb.add("ball, white", parts[0], colors[0]);
  glb.add("ball, red", parts[1], colors[1]);
}

}  // namespace

Glb pool() {
  Glb glb("pool");
  add_basin(glb);
  add_deck(glb);
  add_ball(glb);
  glb.add("step", box({-kHalfX + 0.3f, 0.18f, -0.6f}, {0.3f, 0.18f, 0.6f}),
          glb.lambert("step", {0.6f, 0.64f, 0.64f}));
  glb.add("water", water_surface(), glb.glass("water", 1.33f, {0.55f, 0.86f, 0.92f}, 2.5f));
  glb.add("sun", quad({-2.1f, 7.4f, -2.0f}, {0.36f, 0, 0}, {0, -0.08f, 0.36f}),
          glb.emitter("sun", {1500, 1330, 1080}));
  glb.add("sky", quad({-4, 8.5f, -4}, {8, 0, 0}, {0, 0, 8}), glb.emitter("sky", {0.34f, 0.45f, 0.62f}));
  glb.add_camera("main", {1.9f, 2.95f, 3.15f}, {-0.05f, 0.62f, -0.05f}, 0.72f);
  glb.add_camera("above", {0, 5.2f, 0}, {0, 0, 0}, 0.62f, {0, 0, -1});
  glb.add_camera("edge", {-1.45f, 1.55f, 1.9f}, {0.35f, 0.6f, -0.2f}, 0.75f);
  return glb;
}

}  // namespace photond::samples
