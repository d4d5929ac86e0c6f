#include "core/trace/box_lines.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/math/frame.h"
#include "core/math/warp.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

constexpr int kCells = 12;    // along each side of a square across the lines
constexpr int kFine = 40;     // points along each side of a cell
constexpr float kSide = 8;    // of the square

// Across a direction through the box's centre, the part of each cell by whose lines the box is met.
std::vector<double> met(const BoxLines& box, const Frame& across) {
  std::vector<double> parts(kCells * kCells, 0);
  const float step = kSide / (kCells * kFine);
  for (int y = 0; y < kCells * kFine; ++y) {
    for (int x = 0; x < kCells * kFine; ++x) {
      const float s = (static_cast<float>(x) + 0.5f) * step - kSide / 2, t = (static_cast<float>(y) + 0.5f) * step - kSide / 2;
      const auto cell = static_cast<std::size_t>(y / kFine * kCells + x / kFine);
      parts[cell] += box.meets(box.center() + s * across.s + t * across.t, across.n) ? 1.0 / (kFine * kFine) : 0;
    }
  }
  return parts;
}

// Boxes, one of them flat, seen along their axes and aslant.
TEST(BoxLines, FillTheBoxEvenly) {
  const Bounds3 boxes[] = {{{1, 2, 3}, {2, 4, 7}}, {{-2, 0, -1}, {2, 0, 1}}};
  const Vec3 directions[] = {{0, -1, 0}, glm::normalize(Vec3(1, -2, 0.5f)), glm::normalize(Vec3(-0.3f, 1, 1))};
  for (const Bounds3& bounds : boxes) {
    for (const Vec3& direction : directions) {
      const BoxLines box(bounds);
      const Frame across(direction);
      const std::vector<double> parts = met(box, across);
      double cells = 0;
      for (const double part : parts) cells += part;
      const double cell_area = kSide * kSide / (kCells * kCells);
      EXPECT_NEAR(box.area(direction), cells * cell_area, 0.01 * cells * cell_area);
      constexpr int kDraws = 100'000;
      std::vector<double> observed(parts.size(), 0), expected;
      for (const double part : parts) expected.push_back(kDraws * part / cells);
      Rng rng(1, RngPurpose::pilot, 0, 0);
      for (int i = 0; i < kDraws; ++i) {
        const Vec2 u = rng.next2();
        const Vec3 local = across.to_local(box.sample(direction, {u, rng.next()}) - box.center());
        const auto x = static_cast<int>((local.x / kSide + 0.5f) * kCells), y = static_cast<int>((local.y / kSide + 0.5f) * kCells);
        ASSERT_TRUE(std::min(x, y) >= 0 && std::max(x, y) < kCells);
        ++observed[static_cast<std::size_t>(y * kCells + x)];
      }
      EXPECT_GT(test::chi2_test(observed, expected), test::kSignificance);
    }
  }
}

TEST(BoxLines, EnterByFacesThatAreSeen) {
  const BoxLines box({{0, 0, 0}, {1, 2, 3}});
  const Vec3 direction = glm::normalize(Vec3(1, -2, 0.5f));
  Rng rng(2, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    const Vec2 u = rng.next2();
    const Vec3 at = box.sample(direction, {u, rng.next()});
    EXPECT_TRUE(at.x == 0 || at.y == 2 || at.z == 0);
  }
}

TEST(BoxLines, MeanAreaIsThatOverAllDirections) {
  const BoxLines box({{0, 0, 0}, {1, 2, 3}});
  const test::Sample areas = test::draw(100'000, [&](Rng& rng) {
    return static_cast<double>(box.area(square_to_sphere(rng.next2())));
  });
  EXPECT_TRUE(test::agrees(areas, static_cast<double>(box.mean_area())));
}

TEST(BoxLines, ThereAreNoneOfAnEmptyBox) {
  EXPECT_EQ(BoxLines(Bounds3{}).area({0, 0, 1}), 0);
  EXPECT_EQ(BoxLines({{0, 0, 0}, {1, 1, 0}}).area({1, 0, 0}), 0) << "seen from its edge";
}

}  // namespace
}  // namespace photond
