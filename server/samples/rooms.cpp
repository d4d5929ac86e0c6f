#include "scenes.h"

namespace photond::samples {

void add_room(Glb& glb, const Rgb& left, const Rgb& right, const Rgb& rest) {
  const int plain = glb.lambert("plaster", rest);
  glb.add("floor", quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}), plain);
  glb.add("ceiling", quad({-1, 2, -1}, {2, 0, 0}, {0, 0, 2}), plain);
  glb.add("back wall", quad({-1, 0, -1}, {2, 0, 0}, {0, 2, 0}), plain);
  glb.add("left wall", quad({-1, 0, 1}, {0, 0, -2}, {0, 2, 0}), glb.lambert("left", left));
  glb.add("right wall", quad({1, 0, -1}, {0, 0, 2}, {0, 2, 0}), glb.lambert("right", right));
}

Glb cornell_box() {
  Glb glb("cornell_box");
  add_room(glb, {0.61f, 0.06f, 0.06f}, {0.12f, 0.45f, 0.09f}, Rgb(0.73f, 0.72f, 0.68f));
  const int white = glb.lambert("white", Rgb(0.73f, 0.72f, 0.68f));
  glb.add("tall box", box({-0.34f, 0.6f, -0.32f}, {0.29f, 0.6f, 0.29f}, 0.3f), white);
  glb.add("short box", box({0.36f, 0.29f, 0.3f}, {0.29f, 0.29f, 0.29f}, -0.3f), white);
  glb.add("light", quad({-0.28f, 1.998f, -0.28f}, {0.56f, 0, 0}, {0, 0, 0.56f}),
          glb.emitter("light", {18, 15.5f, 12}));
  glb.add_camera("main", {0, 1, 3.9f}, {0, 1, 0}, 0.686f);
  glb.add_camera("corner", {0.85f, 1.6f, 1.5f}, {-0.25f, 0.6f, -0.4f}, 0.9f);
  glb.add_camera("floor", {-0.75f, 0.25f, 1.3f}, {0.25f, 0.55f, -0.3f}, 0.9f);
  return glb;
}

Glb glass_and_mirror() {
  Glb glb("glass_and_mirror");
  add_room(glb, {0.62f, 0.30f, 0.07f}, {0.07f, 0.22f, 0.46f}, Rgb(0.74f, 0.73f, 0.71f));
  glb.add("mirror sphere", sphere({-0.42f, 0.4f, -0.38f}, 0.4f, 96), glb.metal("mirror", Rgb(0.95f), 0));
  glb.add("glass sphere", sphere({0.4f, 0.36f, 0.28f}, 0.36f, 96), glb.glass("glass", 1.5f, Rgb(1), 1));
  glb.add("small sphere", sphere({-0.34f, 0.14f, 0.55f}, 0.14f, 64),
          glb.lambert("terracotta", {0.62f, 0.17f, 0.1f}));
  glb.add("light", quad({-0.13f, 1.998f, -0.13f}, {0.26f, 0, 0}, {0, 0, 0.26f}),
          glb.emitter("light", {80, 70, 56}));
  glb.add_camera("main", {0, 1, 3.9f}, {0, 1, 0}, 0.686f);
  glb.add_camera("caustic", {0.25f, 0.75f, 1.75f}, {0.3f, 0.2f, 0.15f}, 0.62f);
  glb.add_camera("above", {-0.6f, 1.75f, 1.4f}, {0.02f, 0.2f, -0.05f}, 0.75f);
  return glb;
}

Glb lantern() {
  Glb glb("lantern");
  const int wall = glb.lambert("wall", {0.62f, 0.58f, 0.52f});
  const int wood = glb.lambert("wood", {0.42f, 0.25f, 0.13f});
  glb.add("floor", quad({-1.6f, 0, 2.2f}, {3.2f, 0, 0}, {0, 0, -3.7f}),
          glb.lambert("floor", {0.36f, 0.27f, 0.2f}));
  glb.add("ceiling", quad({-1.6f, 2.4f, -1.5f}, {3.2f, 0, 0}, {0, 0, 3.7f}), wall);
  glb.add("back wall", quad({-1.6f, 0, -1.5f}, {3.2f, 0, 0}, {0, 2.4f, 0}), wall);
  glb.add("front wall", quad({1.6f, 0, 2.2f}, {-3.2f, 0, 0}, {0, 2.4f, 0}), wall);
  glb.add("left wall", quad({-1.6f, 0, 2.2f}, {0, 0, -3.7f}, {0, 2.4f, 0}),
          glb.lambert("blue wall", {0.12f, 0.24f, 0.38f}));
  glb.add("right wall", quad({1.6f, 0, -1.5f}, {0, 0, 3.7f}, {0, 2.4f, 0}), wall);
  glb.add("table", box({0, 0.46f, 0}, {1.05f, 0.04f, 0.55f}), wood);
  for (float x : {-0.95f, 0.95f}) glb.add("table leg", box({x, 0.21f, 0}, {0.05f, 0.21f, 0.45f}), wood);

  const Vec3 center(0, 0.84f, 0);
  const int iron = glb.metal("iron", Rgb(0.28f, 0.26f, 0.24f), 0.4f);
  const int glass = glb.glass("glass", 1.5f, Rgb(1), 1);
  glb.add("lantern foot", cylinder({0, 0.5f, 0}, 0.2f, 0.14f, 0.045f, 64), iron);
  glb.add("glass, outer surface", sphere(center, 0.29f, 96), glass);
  glb.add("glass, inner surface", sphere(center, 0.265f, 96, true), glass);
  glb.add("lamp post", cylinder(center - Vec3(0, 0.25f, 0), 0.03f, 0.012f, 0.185f, 32), iron);
  glb.add("lamp", sphere(center, 0.06f, 32), glb.emitter("lamp", {330, 235, 130}));

  glb.add("copper sphere", sphere({0.62f, 0.66f, 0.2f}, 0.16f, 64),
          glb.metal("copper", {0.93f, 0.6f, 0.47f}, 0.12f));
  glb.add("torus", torus({-0.6f, 0.565f, 0.22f}, 0.17f, 0.065f, 48), glb.lambert("clay", {0.6f, 0.2f, 0.12f}));
  glb.add("lower book", box({-0.66f, 0.53f, -0.28f}, {0.2f, 0.03f, 0.14f}, 0.35f),
          glb.lambert("green", {0.1f, 0.3f, 0.16f}));
  glb.add("upper book", box({-0.65f, 0.585f, -0.28f}, {0.17f, 0.025f, 0.13f}, 0.1f),
          glb.lambert("ochre", {0.6f, 0.42f, 0.1f}));
  glb.add("vase", cylinder({0.55f, 0.5f, -0.28f}, 0.07f, 0.13f, 0.34f, 96),
          glb.lambert("porcelain", Rgb(0.75f)));
  glb.add_camera("main", {0.35f, 1.45f, 2.1f}, {0, 0.78f, 0}, 0.72f);
  glb.add_camera("lamp", {-0.35f, 1.05f, 1.1f}, {0, 0.8f, 0}, 0.75f);
  glb.add_camera("wall", {1.45f, 1.9f, 2.05f}, {-0.5f, 0.8f, -0.8f}, 0.95f);
  return glb;
}

}  // namespace photond::samples
